/// Mode words: a mode with settings as text, such as `hybrid`, `hybrid,eyes=this` or `remote,bitrate=20M`:
/// the name of the mode, then the settings that differ from the defaults.
#pragma once

#include "tests/network/rehearsal.h"

namespace farshade::study {

/// The settings that words can change in a play.
///
///     that draw the scene       detail=PIXELS, the limit of the geometric error, such as 0.25; 0 is full
///     detail with a server             predictor=NAME  every=N  wait (for the frame's own answer, at most a
///     second) that reproject masks      reprojection=off  band=off  eyes=this  gaps=unknown  edges=nearest
///     hybrid                    ask=whole  code=lz4
///     client-positions          bits=N, an axis
///     remote, delta             bitrate=N, NK or NM, bits a second
///     local                     maps=PIXELS, a side  pcf=TEXELS  redraw=always
///
/// Changes nothing else in `play`. Fault::Malformed names a word that the mode does not have.
[[nodiscard]] Expected<void> set_mode(std::string_view words, Play& play);

}  // namespace farshade::study
