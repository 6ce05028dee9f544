// Capture files: any bytes, as they are and with right checksums. The reader either reads frames to the end
// or returns one sentence that names the file. Frames that were read are written again as the same bytes, and
// their views can be drawn.
#include "vr_client/record/capture_reader.h"

#include <sstream>

#include "tests/fuzz/target.h"
#include "tests/unit/client_record/capture_samples.h"

using namespace farshade;

namespace {

void read_any(const std::string& text) {
  Expected<CaptureReader> reader = CaptureReader::over(std::make_unique<std::istringstream>(text), "fuzzed");
  const auto refused = [](const Error& error) {
    check(error.what.starts_with("fuzzed"), "a refusal names the file");
    for (const char c : error.what) check(c >= ' ' && c <= '~', "a refusal is one plain line");
  };
  if (!reader) return refused(reader.error());
  std::vector<std::byte> again;
  append(reader->header(), again);
  for (;;) {
    const Expected<std::optional<CapturedFrame>> frame = reader->next();
    if (!frame) refused(frame.error());
    if (!frame || !*frame) break;
    for (const View& view : (*frame)->input.views) {
      check(is_valid(view), "views can be drawn");
      check(view.size == reader->header().limits.size, "views have the size of the header");
    }
    check((*frame)->input.timing.period > Duration::zero(), "time can be divided by the period");
    check((*frame)->request || (*frame)->after.empty(), "a frame without a request has no messages after it");
    append(**frame, again);
  }
  // The reader drops some fields of a request, so the bytes may differ from those of the fuzzed file.
  Expected<CaptureReader> once_more =
      CaptureReader::over(std::make_unique<std::istringstream>(
                              std::string(reinterpret_cast<const char*>(again.data()), again.size())),
                          "again");
  check(once_more.has_value(), "a written capture can be read");
  std::vector<std::byte> third;
  append(once_more->header(), third);
  for (;;) {
    const Expected<std::optional<CapturedFrame>> frame = once_more->next();
    check(frame.has_value(), "a written capture can be read");
    if (!*frame) break;
    append(**frame, third);
  }
  check(third == again, "reading and writing gives the same bytes");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto text_of = [](std::span<const std::byte> any) {
    return std::string(reinterpret_cast<const char*>(any.data()), any.size());
  };
  read_any(text_of(bytes));
  read_any(text_of(record_samples::with_right_checksums({bytes.begin(), bytes.end()})));
  return 0;
}
