/** A file on its way to the robot. `fetch` does not say how far a body is: an XMLHttpRequest does. */

import { Problem, readProblem } from "./problem";

/**
 * Resolves to the robot's answer; rejects with a Problem, or with an AbortError once `signal` is aborted.
 *
 * `onShare` is called with how much of the file has been sent, 0 to 1.
 */
export function upload(
  url: string,
  file: Blob,
  headers: Record<string, string>,
  onShare: (share: number) => void,
  signal: AbortSignal,
): Promise<unknown> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    const stop = () => request.abort();
    signal.addEventListener("abort", stop);
    request.open("POST", url);
    for (const [name, value] of Object.entries(headers)) request.setRequestHeader(name, value);
    request.upload.onprogress = ({ loaded, total }) => onShare(total > 0 ? loaded / total : 1);
    request.onloadend = () => signal.removeEventListener("abort", stop);
    request.onabort = () => reject(new DOMException("The upload was cancelled.", "AbortError"));
    request.onerror = () =>
      reject(new Problem(0, "No answer", "The robot did not take the file: the connection ended."));
    request.onload = () => {
      const answer = new Response(request.responseText || null, { status: request.status });
      if (answer.ok) resolve(JSON.parse(request.responseText));
      else void readProblem(answer).then(reject);
    };
    request.send(file);
  });
}
