import { expect, test, vi } from "vitest";
import { Problem } from "../protocol/problem";
import type { TourRest } from "../protocol/tourRest";
import type { TourMedia } from "../protocol/types";
import { MediaControl } from "./mediaControl";

const arm: TourMedia = {
  file: "media/arm.jpg",
  type: "image/jpeg",
  video: false,
  size: 9,
  changed: 0,
  shipped: false,
  tours: [],
};
const photo = new File(["123456789"], "arm.jpg", { type: "image/jpeg" });

function setup() {
  const rest = {
    tourMedia: vi.fn(async () => ({ media: [arm], largest_picture: 9, largest_video: 100 })),
    addTourMedia: vi.fn(async (_: File, onShare: (share: number) => void, __: AbortSignal) => {
      onShare(0.5);
      return arm;
    }),
    deleteTourMedia: vi.fn(async (_: string) => {}),
  };
  return { rest, media: new MediaControl(rest as unknown as TourRest) };
}

test("a file is handed in, with how far it is", async () => {
  const { rest, media } = setup();
  const seen: (number | undefined)[] = [];
  media.upload.subscribe((upload) => seen.push(upload?.share));
  expect(await media.add(photo)).toBe("media/arm.jpg");
  expect(seen).toEqual([undefined, 0, 0.5, undefined]);
  expect(media.list.value?.media).toEqual([arm]);
  expect(rest.addTourMedia).toHaveBeenCalledOnce();
});

test("what is seen to be too large or no picture is not sent", async () => {
  const { rest, media } = setup();
  await media.refresh();
  expect(await media.add(new File(["1234567890"], "big.jpg", { type: "image/jpeg" }))).toBeNull();
  expect(media.refusal.value).toContain("big.jpg is larger than");
  expect(await media.add(new File(["x"], "a.pdf", { type: "application/pdf" }))).toBeNull();
  expect(media.refusal.value).toContain("a.pdf is no picture");
  expect(rest.addTourMedia).not.toHaveBeenCalled();
  expect(await media.add(photo)).toBe("media/arm.jpg");
  expect(media.refusal.value).toBe("");
});

test("a refusal of the robot is said, a cancelled upload is none", async () => {
  const { rest, media } = setup();
  rest.addTourMedia.mockRejectedValueOnce(new Problem(422, "Invalid media", "arm.jpg is a damaged picture."));
  expect(await media.add(photo)).toBeNull();
  expect(media.refusal.value).toBe("Arm.jpg is a damaged picture.");
  rest.addTourMedia.mockImplementationOnce(async (_, __, signal) => {
    media.cancel();
    throw signal.reason;
  });
  expect(await media.add(photo)).toBeNull();
  expect(media.refusal.value).toBe("");
  expect(media.upload.value).toBeNull();
});

test("a deleted file is gone from the list, and a refusal is said", async () => {
  const { rest, media } = setup();
  rest.tourMedia.mockResolvedValueOnce({ media: [], largest_picture: 9, largest_video: 9 });
  await media.remove(arm);
  expect(media.list.value?.media).toEqual([]);
  rest.deleteTourMedia.mockRejectedValueOnce(new Problem(409, "Media in use", "It is shown."));
  await media.remove(arm);
  expect(media.refusal.value).toBe("It is shown.");
});
