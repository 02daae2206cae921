"""The whole paper again (Hsieh 2014): stages with figures, claims with verdicts, errata with proofs."""
