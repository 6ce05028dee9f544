#include "tests/integration/good_client.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <fstream>
#include <stdexcept>

#include "stereo/base/check.h"
#include "stereo/gltf/gltf.h"

namespace farshade {
namespace {

StereoView views_at(std::uint32_t pose, Extent size) {
  StereoView views;
  for (const Side side : kSides) {
    View& view = views[index_of(side)];
    view = {{}, {-0.8, 0.8, 0.7, -0.9}, size};
    view.stage_from_eye.translation = {0.1 * pose - 1.2 + 0.064 * static_cast<double>(index_of(side)), 1.5,
                                       4};
  }
  return views;
}

}  // namespace

Walker::Walker(DatagramPort& port, const LinkTarget& target, Extent size)
    : link_(port, clock_, target, Assembler::kKept + 1), size_(size) {
  if (const auto connected = link_.connect(kPatience); !connected)
    throw std::runtime_error(connected.error().what);
}

std::optional<PerEye<EyeMask>> Walker::next_masks(Duration patience) {
  frame_ = next(frame_);
  const Time shown(Duration(std::chrono::milliseconds(14)) * frame_.value);
  link_.request({{frame_, shown, Time{}, views_at((frame_.value - 1) % kPoses, size_)}}, shown);
  if (!link_.wait_for(frame_, patience)) return std::nullopt;
  return link_.receiver().find(frame_)->masks;
}

LinkTarget target_of(const Peer& server, const SharedKey& key, const std::string& scene) {
  const Expected<Scene> loaded = load_scene(scene);
  if (!loaded) throw std::runtime_error(loaded.error().what);
  return {server, key, loaded->hash, {narrow<std::uint32_t>(loaded->lights.size())}};
}

double memory_KiB(pid_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/smaps_rollup");
  for (std::string word; file >> word;)
    if (word == "Rss:" && file >> word) return std::stod(word);
  ADD_FAILURE() << "cannot read the memory of process " << pid;
  return NAN;
}

std::uint64_t Counts::of(const std::string& what) const {
  for (std::size_t at = line.find(' ' + what); at != line.npos; at = line.find(' ' + what, at + 1)) {
    const std::size_t end = at + 1 + what.size();
    const bool whole_words = end == line.size() || std::isalnum(static_cast<unsigned char>(line[end])) == 0;
    std::size_t first = at;
    while (first > 0 && std::isdigit(static_cast<unsigned char>(line[first - 1])) != 0) --first;
    if (whole_words && first < at) return std::stoull(line.substr(first, at - first));
  }
  return 0;
}

Counts counts_of(RunningServer& server) {
  server.program().send(SIGUSR1);
  auto line = server.program().line_after("rt_server: ");
  while (line && (line->starts_with("rays: ") || line->starts_with("scene fetch: ")))
    line = server.program().line_after("rt_server: ");
  EXPECT_TRUE(line.has_value());
  return {line.value_or("")};
}

}  // namespace farshade
