// Requests to the server: JSON to JSON. A refusal is thrown as an Error with the message of the server.

export async function ask(name, content = {}) {
  let answer;
  try {
    answer = await fetch(`/ask/${name}`, {
      method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(content),
    });
  } catch {
    throw new Error("The server of this page does not respond. Check that `cycloid-mj app` is still running.");
  }
  if (!answer.headers.get("Content-Type")?.startsWith("application/json")) throw new Error(await answer.text());
  const data = await answer.json();
  if (!answer.ok || "refused" in data) throw new Error(data.refused ?? data.error);
  return data;
}

// Send only the newest request: those that arrive while an older one is being answered replace each other.
export function newest(name, shown, failed) {
  let waiting = null, busy = false, round = 0;
  async function go() {
    busy = true;
    while (waiting) {
      const [content, at] = [waiting, round];
      waiting = null;
      try {
        const data = await ask(name, content);
        if (at === round) shown(data);
      } catch (error) {
        if (at === round) failed(error.message);
      }
    }
    busy = false;
  }
  return {
    ask(content) { waiting = content; round += 1; if (!busy) go(); },
    drop() { waiting = null; round += 1; },
  };
}

// Start a job and poll it until it ends; `data` is called with each state. Return the last state.
export async function work(content, data = () => {}) {
  let job = await ask("job", content);
  data(job);
  while (job.state === "queued" || job.state === "running") {
    await new Promise(done => setTimeout(done, 250));
    job = await ask("status", { job: job.job });
    data(job);
  }
  if (job.error) throw new Error(job.error);
  return job;
}

export const stop = job => ask("stop", { job });

export function download(job) {
  for (const name of job.files) {
    const link = Object.assign(document.createElement("a"), { href: `/file/${job.job}/${encodeURIComponent(name)}`, download: name });
    document.body.append(link);
    link.click();
    link.remove();
  }
}
