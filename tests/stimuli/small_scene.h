// A scene of a few lines that has one of everything; the tests break it in one place each.
#pragma once

#include "base/json.h"
#include "stimuli/scene.h"
#include "tests/support/temp_folder.h"

namespace equilux {

inline Json make_small_scene() {
  return parse_json(R"({
    "schema": "equilux-scene", "schema_version": 1, "name": "small",
    "camera": {"position": [0, -4, 1.5], "target": [0.1, 0, 1], "up": [0, 0, 1], "vertical_fov_degrees": 40},
    "materials": [
      {"name": "MS", "model": "ward-duer", "rho_d": [0.03, 0.03, 0.03], "rho_s": [0.22, 0.22, 0.22], "alpha": 0.05},
      {"name": "LG", "model": "lambertian", "rho_d": [0.19, 0.19, 0.19]},
      {"name": "floor", "model": "lambertian", "rho_d": [0.5, 0.4, 0.3]}
    ],
    "meshes": [
      {"name": "ball", "sphere": {"radius": 0.4, "subdivisions": 2}},
      {"name": "blob", "blob": {"radius": 0.4, "amplitude": 0.1, "frequency": 4, "seed": 1, "subdivisions": 2}},
      {"name": "ground", "quad": {"u": [4, 0, 0], "v": [0, 4, 0]}},
      {"name": "post", "lathe": {"profile": [[0.1, 0], [0.1, 1]], "segments": 8}},
      {"name": "pair", "group": [{"mesh": "post"}, {"mesh": "ball", "at": [0, 0, 1]}]},
      {"name": "scan", "file": {"path": "scan.obj"}}
    ],
    "instances": [
      {"mesh": "ground", "material": "floor", "at": [-2, -2, 0]},
      {"mesh": "pair", "material": "LG", "at": [1, 1, 0], "turn_degrees": 30}
    ],
    "object": {
      "stand": [0.25, 0.5, 0.75],
      "geometries": [
        {"name": "G0", "mesh": "ball"}, {"name": "G1", "mesh": "blob"}, {"name": "Scan", "mesh": "scan"}
      ]
    },
    "lights": [
      {"spot": {"position": [0, 1, 3], "target": [0, 2, 0], "inner_degrees": 10, "outer_degrees": 30,
                "intensity": [10, 10, 10]}},
      {"rectangle": {"corner": [-1, 0, 3], "u": [0, 1, 0], "v": [1, 0, 0], "radiance": [5, 5, 5]},
       "illuminations": ["dir"]}
    ]
  })",
                    "small scene");
}

inline Scene load_scene_of(const TempFolder& folder, const Json& json) {
  return load_scene(folder.write("scene.json", format_json(json)));
}

}  // namespace equilux
