// Who wants to know of what.

export class Events<Map> {
  private readonly listeners: { [Name in keyof Map]?: ((detail: Map[Name]) => void)[] } = {};

  on<Name extends keyof Map>(name: Name, listener: (detail: Map[Name]) => void): void {
    (this.listeners[name] ??= []).push(listener);
  }

  emit<Name extends keyof Map>(name: Name, detail: Map[Name]): void {
    this.listeners[name]?.forEach((listener) => listener(detail));
  }
}
