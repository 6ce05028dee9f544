#include "vr_client/preview/overlay_maker.h"

#include "vr_client/preview/inspection.h"

namespace farshade {
namespace {

/// A copy of the newest mask of a frame, because the link may drop it before the overlay is drawn.
OwnedMask copy_of(const TracedMask& mask) {
  return {.frame = {mask.frame, mask.light_set_revision, mask.views, mask.masks},
          .received_tiles = mask.received_tiles,
          .requested = mask.requested ? std::optional(*mask.requested) : std::nullopt};
}

/// All that the overlays of a frame are drawn from.
struct KeptFrame {
  FrameToMeasure frame;
  std::optional<OwnedMask> newest;
  Controls controls;
};

PerEye<Image<Rgb8>> draw(const KeptFrame& kept) {
  std::optional<TracedMask> newest;
  if (kept.newest) newest.emplace(kept.newest->traced());
  PerEye<Image<Rgb8>> pictures;
  for (const Side side : kSides) {
    const std::size_t eye = index_of(side);
    pictures[eye] = overlaid({.side = side,
                              .view = kept.frame.shown.views[eye],
                              .shown = kept.frame.pictures[eye],
                              .reference = nullptr,
                              .report = kept.frame.report[eye],
                              .ages = kept.frame.ages,
                              .newest = newest ? &*newest : nullptr,
                              .light = kept.controls.light},
                             kept.controls);
  }
  return pictures;
}

}  // namespace

void OverlayMaker::begin(const FrameView& view, Renderer& renderer, const Controls& controls) {
  const Time before = kSteadyClock.now();
  if (drawing_.valid() || (next_ && before < *next_)) return;
  KeptFrame kept{read_back(view, renderer), std::nullopt, controls};
  if (!view.masks.empty()) kept.newest = copy_of(view.masks[0]);
  drawing_ = std::async(std::launch::async, [kept = std::move(kept)] { return draw(kept); });
  const Time now = kSteadyClock.now();
  next_ =
      now +
      Duration(static_cast<Duration::rep>(static_cast<double>((now - before).count()) * (1 / kMostTime - 1)));
}

std::optional<PerEye<Image<Rgb8>>> OverlayMaker::take() {
  if (!drawing_.valid() || drawing_.wait_for(Duration::zero()) != std::future_status::ready)
    return std::nullopt;
  return drawing_.get();
}

}  // namespace farshade
