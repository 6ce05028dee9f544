/// The option --stand of the client and of the study.
#pragma once

#include <CLI/CLI.hpp>

#include "stereo/scene/stand.h"

namespace farshade {

/// `stand` must outlive the parsing.
inline CLI::Option* add_stand_option(CLI::App& app, std::optional<Stand>& stand) {
  return app.add_option_function<std::string>(
      "--stand",
      [&stand](const std::string& text) {
        const Expected<Stand> parsed = parse_stand(text);
        if (!parsed) throw CLI::ValidationError("--stand", parsed.error().what);
        stand = *parsed;
      },
      "where the head starts, instead of at the scene's reference camera: X,Y,Z in metres and perhaps a "
      "heading in degrees, such as -3.4,1.4,-4,180; heading 0 is -z and 90 is -x");
}

}  // namespace farshade
