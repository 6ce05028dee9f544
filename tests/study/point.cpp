#include "tests/study/point.h"

#include <algorithm>
#include <random>

#include "tests/study/comparison.h"
#include "tests/study/figures.h"
#include "tests/study/mode_words.h"

namespace farshade::study {

Expected<nlohmann::json> measure_point(Play play_settings, const Network& network,
                                       const std::filesystem::path& pictures) {
  Figures figures;
  Comparison comparison(figures);
  play_settings.watch = [&](const FrameView&, const FrameRecord& record, const MeasuredFrame* measured) {
    if (measured != nullptr && !record.start_up) comparison.add(*measured);
  };
  play_settings.watch_smooth = [&](const FrameView& view, const FrameRecord& record,
                                   const MeasuredFrame& measured, const PerEye<Image<Rgb8>>& smooth) {
    if (!record.start_up) comparison.add_smooth(view.shown.views, measured.shown, smooth);
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
      const LinkModel waited_for = awaited(own.mode.mode, network.model);
      const std::uint32_t warm_up = warm_up_frames(waited_for, own.refresh_hz);
      own.frames += round_trip_frames(waited_for, own.refresh_hz) + warm_up;
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
