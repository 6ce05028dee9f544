#include "vr_client/modes/way.h"

#include "stereo/base/check.h"

namespace farshade {

std::unique_ptr<Way> make_way(const Session& session) {
  // Where no light casts shadows nobody is asked, and hybrid draws what there is.
  if (session.link == nullptr && answers_for(session.mode.mode) != 0) return make_hybrid(session);
  switch (session.mode.mode) {
    case Mode::Hybrid:
      return make_hybrid(session);
    case Mode::ClientPositions:
      return make_client_positions(session);
    case Mode::ServerGBuffer:
      return make_server_gbuffer(session);
    case Mode::Remote:
      return make_remote(session);
    case Mode::Delta:
      return make_delta(session);
    case Mode::Local:
      return make_local(session);
    case Mode::Full:
      return make_full(session);
  }
  check(false, "a mode that is");
  return nullptr;
}

}  // namespace farshade
