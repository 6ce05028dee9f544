/// What both doctors look at: versions, key files, scene files, socket buffers.
#pragma once

#include <filesystem>

#include "stereo/doctor/finding.h"
#include "stereo/scene/scene.h"

namespace farshade {

/// Protocol, build, compiler and libraries, in one line to compare with the other side's.
[[nodiscard]] Finding check_versions();

enum class KeyFile : std::uint8_t { OfClient, Ring };

/// Is it there, whose is it, who may read it, how many keys does it hold. Says no secret.
[[nodiscard]] Finding check_key_file(const std::filesystem::path& path, KeyFile kind);

/// A scene that was asked for, as load_scene has answered.
[[nodiscard]] Finding check_scene(const Expected<Scene>& scene);

/// What the kernel grants a UDP socket of the buffers that we ask for.
[[nodiscard]] Finding check_socket_buffers();

}  // namespace farshade
