/// Mode words: a way of working as a sweep writes it, such as `hybrid`, `hybrid,eyes=this` or
/// `remote,bitrate=20M`: the mode's name, then what is to be otherwise than by default.
#pragma once

#include "tests/network/rehearsal.h"

namespace farshade::study {

/// What words may say of a play.
///
///     with a server             predictor=NAME  every=N  wait (for the frame's own answer, at most a second)
///     that carry masks over     reprojection=off  band=off  eyes=this  gaps=unknown  edges=nearest
///     client-positions          bits=N, an axis
///     remote, delta             bitrate=N, NK or NM, bits a second
///     local                     maps=PIXELS, a side  pcf=TEXELS  redraw=always
///
/// Leaves all else in `play` alone. Malformed names the word that is none of the mode's.
[[nodiscard]] Expected<void> set_mode(std::string_view words, Play& play);

}  // namespace farshade::study
