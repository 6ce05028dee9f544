#include "vr_client/modes/run_frames.h"

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "stereo/gpu/device.h"
#include "stereo/gpu/device_losses.h"
#include "vr_client/modes/make_pipeline.h"

namespace farshade {
namespace {

tl::unexpected<Error> lost_for_good(const std::string& how, const std::string& why) {
  return fail(Fault::Unavailable,
              fmt::format("the GPU was lost{} ({}): start vr_client again; if it happens often, fewer pixels "
                          "an eye (--size, --xr-scale) are less work",
                          how, why));
}

/// An abandoned device keeps its memory, so there may be none for another one. That is a loss, too.
Expected<void> reopen(const FrameDevice& device) {
  Expected<void> opened;
  gpu::losing_device([&] { opened = device.reopen(); });
  return opened;
}

}  // namespace

Expected<void> run_frames(const FrameDevice& device, const FrameWatcher& watch,
                          const std::function<bool()>& stop) {
  gpu::DeviceLosses losses(kEnoughFrames);
  const auto count = [&](const FrameView& view) {
    watch(view);
    losses.add_work();
  };
  RunPosition position;
  std::optional<std::string> lost;  // why
  for (;;) {
    try {
      if (lost)
        if (const Expected<void> opened = reopen(device); !opened)
          return lost_for_good(" and cannot be opened again", *lost + "; " + opened.error().what);
      const RunContext context = device.context();
      return run(context, *make_pipeline(context), count, stop, position);
    } catch (const vk::DeviceLostError& error) {
      lost = error.what();
    }
    device.clear();
    if (!device.reopen) return lost_for_good("", *lost);
    if (losses.add_loss())
      return lost_for_good(fmt::format(" {} times in a row", gpu::DeviceLosses::kMost), *lost);
    spdlog::warn("frame {}: the GPU was lost ({}); it is opened again", position.frame.value, *lost);
  }
}

}  // namespace farshade
