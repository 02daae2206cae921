"""The result of sizing: up to three drives that meet a requirement, or the maximum torque and remedies."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

from cycloid_mj.base.frame import Frame, make_frame
from cycloid_mj.base.notebook_display import Presented
from cycloid_mj.design import Design
from cycloid_mj.sizing.requirement import Requirement


@dataclass(frozen=True, eq=False)
class SizedDrive:
    """A drive that meets the requirement: why it is shown, its design, figures by key, and reasons by value."""

    title: str
    why: str
    design: Design
    figures: Mapping[str, float]
    reasons: Mapping[str, str]


@dataclass(frozen=True)
class FeasibleChange:
    """A change of the requirement that makes it feasible: in words, and as a requirement."""

    words: str
    requirement: Requirement


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Presented):
    """Drives, the default first; or the maximum torque `most` [N m], what limits it, and remedies."""

    requirement: Requirement
    drives: tuple[SizedDrive, ...]
    most: float = 0.0
    limit: str = ""
    remedies: tuple[FeasibleChange, ...] = ()

    @property
    def asked(self) -> Requirement:
        """The requirement, under its name before 0.3."""
        warnings.warn(
            "the attribute Answer.asked is deprecated: use Answer.requirement", DeprecationWarning, stacklevel=2
        )
        return self.requirement

    @property
    def ways(self) -> tuple[FeasibleChange, ...]:
        """The remedies, under their name before 0.3."""
        warnings.warn("the attribute Answer.ways is deprecated: use Answer.remedies", DeprecationWarning, stacklevel=2)
        return self.remedies

    @property
    def frame(self) -> Frame:
        """The drives, a row each: title and quantities."""
        figures = self.drives[0].figures if self.drives else {}
        return make_frame([{"title": item.title, **item.figures} for item in self.drives], ("title", *figures), {})

    @property
    def line(self) -> str:
        """The requirement, and the drives or the refusal."""
        requirement = (
            f"{self.requirement.ratio}:1, {1e3 * self.requirement.diameter:g} mm, {self.requirement.torque:g} N m"
        )
        drives = ", ".join(f"{item.title} {item.figures['mass_kg']:.3g} kg" for item in self.drives)
        return f"{requirement}; {drives or self.refusal}"

    @property
    def refusal(self) -> str:
        """Return the reason why the requirement is not feasible, with feasible remedies, as a sentence."""
        torque = f"{self.requirement.torque:g} N m"
        options = ", or ".join(remedy.words for remedy in self.remedies)
        remedy = (
            f"{torque} is feasible with {options}"
            if options
            else f"no change of size, discs or material was found that makes {torque} feasible"
        )
        if not self.most:
            return f"not feasible: {self.limit}; {remedy}"
        return f"not feasible: the limit is {self.most:g} N m ({self.limit}); {remedy}"
