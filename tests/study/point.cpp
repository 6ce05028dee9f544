#include "tests/study/point.h"

#include <algorithm>
#include <random>

#include "stereo/image/codec.h"
#include "tests/metrics/flip.h"
#include "tests/metrics/heat_map.h"
#include "tests/metrics/pixels_per_degree.h"
#include "tests/metrics/ssim.h"
#include "tests/study/figures.h"
#include "tests/study/mode_words.h"
#include "vr_client/report/measure.h"

namespace farshade::study {
namespace {

/// The pictures of one frame, with their perceived error.
struct ComparedFrame {
  PerEye<Image<Rgb8>> shown, reference;
  PerEye<Image<float>> error;
  double flip = -1;  ///< the worse eye's
};

/// Compares pictures with perceptual metrics and keeps the worst frame.
class Comparison {
 public:
  explicit Comparison(Figures& figures) : figures_(figures) {}

  void add(const FrameView& view, const MeasuredFrame& frame) {
    ComparedFrame compared{.shown = frame.shown, .reference = frame.reference, .error = {}};
    double worse_ssim = 1;
    for (std::size_t eye = 0; eye < kEyes; ++eye) {
      compared.error[eye] =
          flip(frame.reference[eye], frame.shown[eye], pixels_per_degree(view.shown.views[eye]));
      compared.flip = std::max(compared.flip, mean(compared.error[eye]));
      worse_ssim = std::min(worse_ssim, ssim(frame.reference[eye], frame.shown[eye]));
    }
    figures_.add(Group::Error, "flip", compared.flip);
    figures_.add(Group::Error, "ssim", worse_ssim, Worse::Low);
    if (compared.flip > worst_.flip) worst_ = std::move(compared);
  }

  [[nodiscard]] Expected<void> write(const std::filesystem::path& folder) const {
    if (worst_.flip < 0) return {};
    for (const Side side : kSides) {
      const std::size_t eye = index_of(side);
      const auto path = [&](const char* what) { return folder / (std::string(name_of(side)) + what); };
      for (const Expected<void>& done : {write_png(path("_shown.png"), worst_.shown[eye]),
                                         write_png(path("_reference.png"), worst_.reference[eye]),
                                         write_png(path("_heat.png"), heat_map(worst_.error[eye]))})
        if (!done) return done;
    }
    return {};
  }

 private:
  Figures& figures_;
  ComparedFrame worst_;
};

}  // namespace

Expected<nlohmann::json> measure_point(Play play_settings, const Network& network,
                                       const std::filesystem::path& pictures) {
  Figures figures;
  Comparison comparison(figures);
  play_settings.watch = [&](const FrameView& view, const FrameRecord& record, const MeasuredFrame* measured) {
    if (measured != nullptr && !record.start_up) comparison.add(view, *measured);
  };
  const Played played = play(play_settings, network);
  add_errors(played, 0, figures);
  add_times(played, first_timed_frame(played, warm_up_frames(network.model, play_settings.refresh_hz)),
            figures);
  if (!pictures.empty())
    if (const Expected<void> written = comparison.write(pictures); !written)
      return tl::unexpected(written.error());
  nlohmann::json told = figures.json();
  told["start_up_frames"] = played.log.start_up_frames();
  return told;
}

Expected<nlohmann::json> measure_rounds(const Play& shared, const Network& network, const Rounds& rounds) {
  struct Entry {
    std::string mode;
    bool again;
    Figures all{};
    nlohmann::json each = nlohmann::json::array();
  };
  std::vector<Entry> entries;
  for (const std::string& mode : rounds.modes) entries.push_back({mode, false});
  entries.push_back({rounds.modes.at(0), true});

  std::mt19937_64 random(rounds.seed);
  std::vector<Entry*> order;
  for (Entry& entry : entries) order.push_back(&entry);
  for (std::uint32_t round = 0; round < rounds.rounds; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    for (Entry* entry : order) {
      Play own = shared;
      own.reference_every = 0;
      if (const Expected<void> set = set_mode(entry->mode, own); !set) return tl::unexpected(set.error());
      // A mode that requests nothing waits for no answer, on no network.
      const LinkModel awaited = answers_for(own.mode.mode) == 0 ? LinkModel{} : network.model;
      const std::uint32_t warm_up = warm_up_frames(awaited, own.refresh_hz);
      own.frames += round_trip_frames(awaited, own.refresh_hz) + warm_up;
      const Played played = play(own, network);
      Figures figures;
      const std::uint32_t first = first_timed_frame(played, warm_up);
      add_times(played, first, figures);
      add_times(played, first, entry->all);
      entry->each.push_back(figures.json());
    }
  }
  nlohmann::json told = nlohmann::json::array();
  for (const Entry& entry : entries)
    told.push_back({{"mode", entry.mode},
                    {"again", entry.again},
                    {"figures", entry.all.json()},
                    {"rounds", entry.each}});
  return told;
}

}  // namespace farshade::study
