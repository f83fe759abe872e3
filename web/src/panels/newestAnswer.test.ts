import { expect, test } from "vitest";
import { NewestAnswer } from "./newestAnswer";

/** Answers when it is let to. */
function slow() {
  const asked: number[] = [];
  const waiting: { resolve(answer: string): void; reject(error: Error): void }[] = [];
  const answers: string[] = [];
  const asker = new NewestAnswer<number, string>(
    (question) => {
      asked.push(question);
      return new Promise((resolve, reject) => waiting.push({ resolve, reject }));
    },
    (answer) => answers.push(answer),
    (error) => answers.push(`${error}`),
  );
  const settle = () => new Promise((resolve) => setTimeout(resolve));
  return { asked, waiting, answers, asker, settle };
}

test("while one is under way only the newest of the others waits", async () => {
  const { asked, waiting, answers, asker, settle } = slow();
  for (const question of [1, 2, 3, 4]) asker.ask(question);
  expect(asked).toEqual([1]);
  waiting[0]!.resolve("one");
  await settle();
  expect(asked).toEqual([1, 4]);
  waiting[1]!.resolve("four");
  await settle();
  expect(answers).toEqual(["one", "four"]);
});

test("what was forgotten is not answered, and a failure keeps nobody from asking again", async () => {
  const { waiting, answers, asker, settle } = slow();
  asker.ask(1);
  asker.forget();
  waiting[0]!.resolve("one");
  await settle();
  asker.ask(2);
  waiting[1]!.reject(new Error("gone"));
  await settle();
  asker.ask(3);
  waiting[2]!.resolve("three");
  await settle();
  expect(answers).toEqual(["Error: gone", "three"]);
});
