/** Asks one question at a time, the newest next; those in between are never asked. */
export class NewestAnswer<Question, Answer> {
  private waiting: { question: Question } | null = null;
  private busy = false;
  private forgotten = false;

  /** `answered` gets each answer, unless a newer question has none any more (`forget`). */
  constructor(
    private readonly answer: (question: Question) => Promise<Answer>,
    private readonly answered: (answer: Answer) => void,
    private readonly failed: (error: unknown) => void,
  ) {}

  ask(question: Question): void {
    this.waiting = { question };
    if (!this.busy) void this.run();
  }

  /** What is under way is not answered any more. */
  forget(): void {
    this.waiting = null;
    this.forgotten = true;
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.waiting) {
      const { question } = this.waiting;
      this.waiting = null;
      this.forgotten = false;
      try {
        const answer = await this.answer(question);
        if (!this.forgotten) this.answered(answer);
      } catch (error) {
        if (!this.forgotten) this.failed(error);
      }
    }
    this.busy = false;
  }
}
