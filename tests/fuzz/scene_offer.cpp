// The server's offer of its scene, and the other messages of a fetch: whatever is read has names below the
// cache's folder and sizes within the bounds, and reads back the same after writing.
#include "stereo/fetch/scene_offer.h"

#include <filesystem>

#include "stereo/messages/fetch_messages.h"
#include "tests/fuzz/target.h"

using namespace farshade;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  static_cast<void>(decode_fetch_answer(bytes));
  static_cast<void>(decode_fetch_request(bytes));
  const auto offer = decode_offer(bytes);
  if (!offer) return 0;
  check(total_bytes(offer->files) <= kMostScene_bytes, "the size is bounded");
  for (const OfferedFile& file : offer->files) {
    const auto path = (std::filesystem::path("/cache") / file.name).lexically_normal().string();
    check(path.starts_with("/cache/") && path.size() == 7 + file.name.size(), "a name stays in the folder");
  }
  const auto again = decode_offer(encode(*offer));
  check(again && again->files == offer->files, "a written offer reads back the same");
  return 0;
}
