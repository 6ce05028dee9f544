/// A scene of one triangle, with one light or none, as a file.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace farshade {

/// Writes a scene of one triangle: (0 0 0), (1 0 0), (0 1 0). `light` is a light of KHR_lights_punctual, 2 m
/// before it; empty: none. Returns the path.
inline std::string one_triangle(const std::filesystem::path& folder, const char* name,
                                const std::string& light) {
  const std::filesystem::path path = folder / name;
  const std::string extension = light.empty() ? ""
                                              : R"(,"extensionsUsed":["KHR_lights_punctual"],
    "extensions":{"KHR_lights_punctual":{"lights":[)" +
                                                    light + "]}}";
  const std::string lamp =
      light.empty() ? "" : R"(,{"translation":[0,0,2],"extensions":{"KHR_lights_punctual":{"light":0}}})";
  std::ofstream(path) << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0)"
                      << (light.empty() ? "" : ",1") << R"(]}],"nodes":[{"mesh":0})" << lamp << "]"
                      << extension << R"(,
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,
      "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
  return path.string();
}

/// No light of it casts shadows.
inline std::string scene_with_a_dark_light(const std::filesystem::path& folder) {
  return one_triangle(folder, "dark.gltf", R"({"type":"point","intensity":0})");
}

}  // namespace farshade
