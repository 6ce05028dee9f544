/// Where tests that draw find their files, and on which device they draw: in the repository and on lavapipe,
/// unless the environment says otherwise, as the `check` of scripts/gpu-bundle does on other machines.
#pragma once

#include <filesystem>
#include <string>

namespace farshade {

/// FARSHADE_TEST_ROOT: a folder with the files of the repository that tests read. By default the repository.
[[nodiscard]] std::filesystem::path test_root();

/// A file of assets/ below the root.
[[nodiscard]] std::string asset(const std::string& file);

/// A scene or a head recording in the folder shared/ beside the root, where some machines have larger ones.
[[nodiscard]] std::string shared_scene(const std::string& file);
[[nodiscard]] std::string shared_trace(const std::string& file);

/// FARSHADE_TEST_OUT: the folder of pictures that tests write for people to look at. By default the build
/// folder.
[[nodiscard]] std::filesystem::path test_output();

/// FARSHADE_TEST_GPU: part of the name of the device that tests draw on. By default lavapipe's.
[[nodiscard]] std::string test_gpu();

}  // namespace farshade
