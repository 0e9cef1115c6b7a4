// A program with the package, whichever way it came: two boxes that touch, a third that does not, told to whoever asks.

export async function run(createWorld) {
  const world = await createWorld({ objects: 3, events: true });
  world.insertMany(new Float32Array([0, 0, 0, 1, 1, 1, 1, 1, 1, 2, 2, 2, 5, 5, 5, 6, 6, 6]));
  return `pairs ${world.step().pairs.join()}`;
}

export async function tell(createWorld) {
  const said = await run(createWorld).catch((error) => String(error));
  if (typeof document === "undefined") {
    // Bun has `postMessage` outside of workers, too.
    typeof importScripts === "function" ? postMessage(said) : console.log(said);
  } else {
    await fetch("/seen", { method: "POST", body: said });
  }
}
