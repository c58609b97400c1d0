"use strict";

// The server sends a picture only when asked: this page asks once it has shown the one before,
// so a slow machine misses pictures instead of falling behind.
const RETRY = 2000;
const shown = (id) => document.getElementById(id);
const picture = shown("picture");

function tell(kind, text) {
  if (shown("state").textContent === text) return;
  shown("state").dataset.kind = kind;
  shown("state").textContent = text;
}

async function show(data) {
  const address = URL.createObjectURL(new Blob([data], { type: "image/jpeg" }));
  const last = picture.src;
  picture.src = address;
  // A picture that cannot be decoded is skipped; the next one will do.
  await picture.decode().catch(() => {});
  if (last) URL.revokeObjectURL(last);
  picture.hidden = false;
  shown("empty").hidden = true;
}

function watch() {
  const socket = new WebSocket(`ws://${location.host}/pictures`);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => socket.send("next");
  socket.onmessage = async (message) => {
    if (typeof message.data === "string") {
      const { time, pace } = JSON.parse(message.data);
      shown("time").textContent = `${time.toFixed(1)} s`;
      shown("pace").textContent = pace > 0 ? `${pace.toFixed(1)} ×` : "–";
      return;
    }
    tell("go", "Running");
    await show(message.data);
    if (socket.readyState === WebSocket.OPEN) socket.send("next");
  };
  socket.onclose = (event) => {
    if (event.code === 1000 || event.code === 1012) {
      tell("wait", picture.hidden ? "The run has ended" : "The run has ended; this is its last picture");
      shown("empty").textContent = "The run ended before there was a picture.";
      return;
    }
    tell("stop", "No connection to the run; trying again");
    setTimeout(watch, RETRY);
  };
}

watch();
