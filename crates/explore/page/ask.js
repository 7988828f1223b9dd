// Requests to the program that has served this page: the token is in the page's own address, and so in theirs.

const PATIENCE = 4;

export async function get(name) {
  return (await checked(await fetch(name))).json();
}

// Posts a question; 503, too many at once, is asked again a little later.
export async function post(name, body, signal) {
  for (let tries = 0; ; tries += 1) {
    const response = await fetch(name, { method: "POST", body: JSON.stringify(body), signal });
    if (response.status === 503 && tries < PATIENCE) {
      await pause(100 * 2 ** tries, signal);
      continue;
    }
    await checked(response);
    const numbers = response.headers.get("content-type") === "application/octet-stream";
    return numbers ? response.arrayBuffer() : response.json();
  }
}

async function checked(response) {
  if (response.ok) return response;
  let message = `${response.status} ${response.statusText}`;
  try {
    message = (await response.json()).error ?? message;
  } catch { /* no JSON: the code must do */ }
  throw new Error(message);
}

function pause(milliseconds, signal) {
  return new Promise((resolve, reject) => {
    const timer = setTimeout(resolve, milliseconds);
    signal?.addEventListener("abort", () => { clearTimeout(timer); reject(signal.reason); }, { once: true });
  });
}

export const gone = (error) => error?.name === "AbortError";
