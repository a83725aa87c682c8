// Draws the messages in window.picture as Foxglove's 3D panel does, with the panel's settings.
import { Renderer } from "@foxglove/studio-base/src/panels/ThreeDeeRender/Renderer";
import { Label } from "@foxglove/three-text";

// The released three-text lacks this method, which labels that are not opaque need.
Label.prototype.setOpacity ??= () => {};

const { settings, messages } = window.picture;
const renderer = new Renderer(document.querySelector("canvas"), settings, "3d");
renderer.setColorScheme("dark", settings.scene.backgroundColor);
renderer.setTopics(messages.map(({ topic, schemaName }) => ({ name: topic, schemaName })));
renderer.setCurrentTime(BigInt(Date.now()) * 1_000_000n);
for (const message of messages) {
  renderer.addMessageEvent({ ...message, receiveTime: { sec: 1, nsec: 0 }, sizeInBytes: 0 });
}
const draw = () => {
  renderer.animationFrame();
  requestAnimationFrame(draw);
};
draw();
