import { App } from "./app";
import { Curtain } from "./curtain";
import { Script } from "./script";

const curtain = new Curtain();

if (document.createElement("canvas").getContext("webgl2")) {
  const app = new App(document.body);
  window.radiosity = new Script(app);
  void app.start();
} else {
  document.body.append(curtain.element);
  curtain.say(
    "This browser cannot draw the scene",
    "The viewer needs WebGL 2, which is missing or switched off. Use a current Firefox, Chrome, Edge or Safari with " +
      "hardware acceleration switched on in its settings; `radiosity render` makes pictures without any browser.",
  );
}
