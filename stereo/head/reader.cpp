#include "stereo/head/reader.h"

#include <cmath>

#include "stereo/base/files.h"
#include "stereo/head/formats.h"
#include "stereo/head/rows.h"

namespace farshade {
namespace {

bool is_eyenavgs(std::string_view text) {
  rows::Lines lines(text, "");
  std::string_view line;
  while (lines.next(line))
    if (!is_comment(line)) return line.starts_with("ViewIndex,");
  return false;
}

/// How files begin that are no text in UTF-8.
struct Signature {
  std::string_view start, what;
};
constexpr Signature kSignatures[] = {{"\xFF\xFE", "UTF-16 text: save it as UTF-8"},
                                     {"\xFE\xFF", "UTF-16 text: save it as UTF-8"},
                                     {"{", "JSON"},
                                     {"[", "JSON"},
                                     {"#ROSBAG", "a ROS bag"},
                                     {"SQLite format 3", "a database, perhaps a ROS 2 bag"},
                                     {"PK\x03\x04", "a ZIP archive or a spreadsheet"},
                                     {"\x93NUMPY", "a NumPy array"}};

struct KnownScale {
  std::string_view name_part;
  double units_a_metre;
};
constexpr KnownScale kKnownScales[] = {{"eyenavgs_truck", 0.76}, {"eyenavgs_room", 2.0}};

Expected<double> scale_of(bool eyenavgs, std::string_view name, const HeadFileOptions& options) {
  if (const std::optional<double> given = options.units_a_metre) {
    if (std::isfinite(*given) && *given > 0) return *given;
    return fail(Fault::OutOfRange, "the scene scale of a recording must be a positive number");
  }
  if (!eyenavgs) return options.axes ? options.axes->units_a_metre : 1.0;
  for (const KnownScale& known : kKnownScales)
    if (name.find(known.name_part) != name.npos) return known.units_a_metre;
  return fail(Fault::Unsupported,
              std::string(name) +
                  ": an EyeNavGS recording, whose name does not tell its scene: give --trace-scale, how many "
                  "of its units are a metre (0.76 in its scene truck, 2 in room)");
}

}  // namespace

Expected<HeadRecording> parse_head_recording(std::string_view text, std::string_view name,
                                             const HeadFileOptions& options) {
  for (const Signature& signature : kSignatures)
    if (text.starts_with(signature.start))
      return fail(Fault::Unsupported,
                  std::string(name) + ": is no table of head poses but " + std::string(signature.what));
  const bool eyenavgs = is_eyenavgs(text);
  const Expected<double> scale = scale_of(eyenavgs, name, options);
  if (!scale) return tl::unexpected(scale.error());
  return eyenavgs ? formats::read_eyenavgs(text, name, *scale, options)
                  : formats::read_table(text, name, *scale, options);
}

Expected<HeadRecording> load_head_recording(const std::filesystem::path& path,
                                            const HeadFileOptions& options) {
  const Expected<std::vector<std::byte>> bytes = read_file(path, kMaxRecordingBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  return parse_head_recording(text, path.filename().string(), options);
}

}  // namespace farshade
