/// The option --stand of the client and of the study.
#pragma once

#include <CLI/CLI.hpp>

#include "stereo/options/parse_start_pose.h"
#include "stereo/scene/start_pose.h"

namespace farshade {

/// `start_pose` must outlive the parsing.
inline CLI::Option* add_start_pose_option(CLI::App& app, std::optional<StartPose>& start_pose) {
  return app.add_option_function<std::string>(
      "--stand",
      [&start_pose](const std::string& text) {
        const Expected<StartPose> parsed = parse_start_pose(text);
        if (!parsed) throw CLI::ValidationError("--stand", parsed.error().what);
        start_pose = *parsed;
      },
      "where the head starts, instead of at the scene's reference camera: X,Y,Z in metres and perhaps a "
      "heading in degrees, such as -3.4,1.4,-4,180; heading 0 is -z and 90 is -x");
}

}  // namespace farshade
