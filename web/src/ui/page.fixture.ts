/** Components for tests: drawn into elements that know no more than what they are made of, and pressed there. */

import { type ComponentChild, h, render } from "preact";
import { act } from "preact/test-utils";
import { type App, AppContext } from "../state/context";

type Handler = (this: Element, event: FakeEvent) => void;

interface FakeEvent {
  type: string;
  defaultPrevented: boolean;
  preventDefault: () => void;
  stopPropagation: () => void;
  target: Element;
  currentTarget: Element;
}

class Node {
  parentNode: Element | null = null;

  get nextSibling(): Element | Text | null {
    const beside: readonly Node[] = this.parentNode?.childNodes ?? [];
    return this.parentNode?.childNodes[beside.indexOf(this) + 1] ?? null;
  }

  remove(): void {
    const others = this.parentNode?.childNodes.filter((node: Node) => node !== this);
    if (this.parentNode && others) this.parentNode.childNodes = others;
    this.parentNode = null;
  }
}

class Text extends Node {
  readonly nodeType = 3;

  constructor(public data: string) {
    super();
  }

  get textContent(): string {
    return this.data;
  }
}

/** Properties are attributes here: what it was given under a name is in `attributes`. */
class Element extends Node {
  readonly nodeType = 1;
  readonly namespaceURI = "http://www.w3.org/1999/xhtml";
  readonly ownerDocument = {
    createElementNS: (_: string, name: string) => new Element(name),
    createTextNode: (words: string) => new Text(words),
  };
  readonly attributes = new Map<string, unknown>();
  readonly style = { setProperty: () => undefined };
  childNodes: (Element | Text)[] = [];
  private readonly handlers = new Map<string, Handler>();

  constructor(readonly localName: string) {
    super();
  }

  get firstChild(): Element | Text | null {
    return this.childNodes[0] ?? null;
  }

  get textContent(): string {
    return this.childNodes.map((node) => node.textContent).join("");
  }

  insertBefore(node: Element | Text, next: Element | Text | null): void {
    node.remove();
    this.childNodes.splice(next ? this.childNodes.indexOf(next) : this.childNodes.length, 0, node);
    node.parentNode = this;
  }

  setAttribute(name: string, value: unknown): void {
    this.attributes.set(name, value);
  }

  removeAttribute(name: string): void {
    this.attributes.delete(name);
  }

  addEventListener(type: string, handler: Handler): void {
    this.handlers.set(type, handler);
  }

  removeEventListener(type: string): void {
    this.handlers.delete(type);
  }

  handle(event: FakeEvent): void {
    event.currentTarget = this;
    this.handlers.get(event.type)?.call(this, event);
  }

  all(): Element[] {
    return this.childNodes.flatMap((node) => (node instanceof Element ? [node, ...node.all()] : []));
  }
}

/** A component in an app of only what it needs. */
export function drawn(component: ComponentChild, app: object) {
  const root = new Element("body");
  const put = (child: ComponentChild) =>
    act(() => render(h(AppContext.Provider, { value: app as App }, child), root as unknown as globalThis.Element));
  void put(component);
  const all = (testid: string) => root.all().filter(({ attributes }) => attributes.get("data-testid") === testid);
  const one = (testid: string): Element => {
    const [found, ...others] = all(testid);
    if (!found || others.length > 0) throw new Error(`${all(testid).length} of ${testid}, not one`);
    return found;
  };
  /** The event as it was left by all that it came to, from the element up. */
  const fire = async (at: Element, type: string, more: object = {}): Promise<FakeEvent> => {
    let goesOn = true;
    const event: FakeEvent = {
      type,
      defaultPrevented: false,
      preventDefault: () => void (event.defaultPrevented = true),
      stopPropagation: () => void (goesOn = false),
      target: at,
      currentTarget: at,
      ...more,
    };
    await act(async () => {
      for (let to: Element | null = at; to && goesOn; to = to.parentNode) to.handle(event);
    });
    return event;
  };
  return {
    all,
    one,
    fire,
    /** As a person does, who can press no button that is disabled. */
    press: async (testid: string): Promise<void> => {
      const button = one(testid);
      if (button.attributes.get("disabled")) throw new Error(`${testid} is disabled`);
      await fire(button, "click");
    },
    words: () => root.textContent,
    close: () => void put(null),
  };
}
