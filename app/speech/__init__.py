"""Speech from text: engines behind one interface, with the times of words and of the mouth. Blocking; no asyncio."""
