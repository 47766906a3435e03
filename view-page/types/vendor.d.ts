// Types of ecs_eco/view/static/vendor.js.
export * from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { default as uPlot } from "uplot";
