#include "stereo/frame/light_changes.h"

#include <algorithm>

namespace farshade {
namespace {

/// The first change after `revision`.
auto first_after(const std::vector<LightChange>& lights, LightSetRevision revision) {
  return std::find_if(lights.begin(), lights.end(),
                      [revision](const LightChange& change) { return is_newer(change.revision, revision); });
}

/// Replaces the light's earlier change; keeps the order of revisions.
void put(std::vector<LightChange>& lights, const LightChange& change) {
  std::erase_if(lights, [&](const LightChange& old) { return old.light == change.light; });
  lights.insert(first_after(lights, change.revision), change);
}

}  // namespace

void change(LightChanges& changes, std::uint32_t light, bool on, const std::optional<LightPose>& pose) {
  changes.revision = next(changes.revision);
  put(changes.lights, {light, changes.revision, on, pose});
}

LightChanges since(const LightChanges& changes, LightSetRevision revision, std::size_t most) {
  const auto first = first_after(changes.lights, revision);
  const auto left = static_cast<std::size_t>(changes.lights.end() - first);
  if (left <= most) return {changes.revision, {first, changes.lights.end()}};
  const auto last = first + static_cast<std::ptrdiff_t>(most);
  return {most == 0 ? revision : (last - 1)->revision, {first, last}};
}

LightChanges up_to(const LightChanges& changes, LightSetRevision revision) {
  return {revision, {changes.lights.begin(), first_after(changes.lights, revision)}};
}

void merge(LightChanges& held, const LightChanges& update) {
  if (!is_newer(update.revision, held.revision)) return;
  for (const LightChange& change : update.lights) {
    const auto same_light = [&](const LightChange& old) { return old.light == change.light; };
    const auto old = std::find_if(held.lights.begin(), held.lights.end(), same_light);
    if (old == held.lights.end() || is_newer(change.revision, old->revision)) put(held.lights, change);
  }
  held.revision = update.revision;
}

}  // namespace farshade
