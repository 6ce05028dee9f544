#include "stereo/sealing/layout.h"

#include "stereo/messages/layout_recorder.h"
#include "stereo/sealing/envelope.h"

namespace farshade {

unsigned layout_hash(ProtocolVersion version) {
  LayoutRecorder io(version);
  record_envelopes(io);
  record_messages(io);
  record_fetch_messages(io);
  return io.hash();
}

void check_layout() {
  check_eq(kLayoutHash, layout_hash(kProtocolVersion),
           "kLayoutHash (stereo/messages/version.h) is the hash of all fields; if they have changed, "
           "kProtocolNumber changes, too");
}

}  // namespace farshade
