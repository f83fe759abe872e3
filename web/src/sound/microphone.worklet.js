// Runs on the audio thread: hands the microphone's samples, as they come, to the page.

class Microphone extends AudioWorkletProcessor {
  process(inputs) {
    const samples = inputs[0][0];
    if (samples) this.port.postMessage(samples);
    return true;
  }
}

registerProcessor("microphone", Microphone);
