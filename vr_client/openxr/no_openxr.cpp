#include "vr_client/openxr/headset_runtime.h"

namespace farshade {

Expected<std::unique_ptr<HeadsetSystem>> HeadsetSystem::open() {
  return fail(Fault::Unavailable,
              "built without OpenXR: install libopenxr-dev (scripts/setup does) and configure again");
}

}  // namespace farshade
