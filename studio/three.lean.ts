// Removes from three.js what the page's pictures never use: headsets, reflections of surroundings,
// and the shaders of physical materials. three.js is one file, so a bundler cannot do this. Its
// version is pinned, and the build fails if a text is missing.
import type { Plugin } from "vite";

const WEBXR_STUB =
  "{ enabled: false, isPresenting: false, getEnvironmentBlendMode() {}, dispose() {}, addEventListener() {}, removeEventListener() {}, setAnimationLoop() {} }";

const REPLACEMENTS: ReadonlyArray<readonly [text: string, by: string]> = [
  ["new WebXRManager( _this, _gl )", WEBXR_STUB],
  ["new WebGLEnvironments( _this )", "{ get: () => null, dispose() {} }"],
  ["m_uniforms.dfgLUT.value = getDFGLUT();", ""],
];

/** Shader texts of materials and lights that the pictures do not use. */
const UNUSED_SHADERS = [
  "lights_physical_pars_fragment",
  "lights_physical_fragment",
  "lightprobes_pars_fragment",
  "transmission_pars_fragment",
  "transmission_fragment",
  "iridescence_fragment",
  "iridescence_pars_fragment",
  "envmap_physical_pars_fragment",
  "lights_toon_pars_fragment",
  "clearcoat_pars_fragment",
  "bumpmap_pars_fragment",
  "normalmap_pars_fragment",
  "displacementmap_pars_vertex",
  "batching_pars_vertex",
  "skinning_pars_vertex",
];
/** Complete shaders of materials that the pictures do not use. */
const UNUSED_MATERIALS = /"#define (STANDARD|TOON|MATCAP|NORMAL)\\n/;

export const leanThree: Plugin = {
  name: "lean-three",
  transform(code, id) {
    if (!/three.build.three\.module\.js$/.test(id)) return null;
    let lean = code;
    for (const [text, by] of REPLACEMENTS) {
      if (!lean.includes(text)) throw new Error(`three has no ${text}`);
      lean = lean.replace(text, () => by);
    }
    for (const name of UNUSED_SHADERS) {
      const found = new RegExp(`^var ${name} = ".*";$`, "m");
      if (!found.test(lean)) throw new Error(`three has no shader ${name}`);
      lean = lean.replace(found, `var ${name} = "";`);
    }
    const emptied = lean.split("\n").map((line) => (UNUSED_MATERIALS.test(line) ? line.replace(/".*"/, '""') : line));
    return { code: emptied.join("\n"), map: null };
  },
};
