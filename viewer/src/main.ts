import { App } from "./app";
import { Script } from "./script";

const app = new App(document.body);
window.radiosity = new Script(app);
void app.start();
