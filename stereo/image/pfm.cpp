/// PFM: "Pf", width and height, -1.0 for little-endian, then floats, bottom row first
/// (P. Debevec, "Portable float map", netpbm's pfm(5)).
#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "stereo/image/formats.h"

namespace farshade {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are written as they lie in memory");

/// Takes the next word of a header and the one white-space byte after it. Empty if there is none.
std::string_view take_word(std::string_view& text) {
  const std::size_t end = text.find_first_of(" \t\r\n");
  if (end == std::string_view::npos) return {};
  const std::string_view word = text.substr(0, end);
  text.remove_prefix(end + 1);
  return word;
}

template <class Number>
std::optional<Number> number_of(std::string_view word) {
  Number value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc{} && end == word.data() + word.size() ? std::optional(value) : std::nullopt;
}

}  // namespace

std::vector<std::byte> encode_pfm(const Image<float>& image) {
  const std::string header =
      "Pf\n" + std::to_string(image.size.width) + " " + std::to_string(image.size.height) + "\n-1.0\n";
  const std::size_t row_bytes = image.size.width * sizeof(float);
  std::vector<std::byte> bytes(header.size() + image.size.height * row_bytes);
  std::memcpy(bytes.data(), header.data(), header.size());
  std::byte* row = bytes.data() + header.size();
  for (std::uint32_t y = image.size.height; y-- > 0; row += row_bytes)
    std::memcpy(row, &image.at(0, y), row_bytes);
  return bytes;
}

Expected<Image<float>> decode_pfm(std::span<const std::byte> file, std::uint64_t max_pixels) {
  std::string_view text(reinterpret_cast<const char*>(file.data()), file.size());
  if (take_word(text) != "Pf") return fail(Fault::Unsupported, "not a one-channel PFM");
  const auto width = number_of<std::uint32_t>(take_word(text));
  const auto height = number_of<std::uint32_t>(take_word(text));
  const auto scale = number_of<double>(take_word(text));
  if (!width || !height || !scale) return fail(Fault::Malformed, "faulty PFM header");
  if (!(*scale < 0)) return fail(Fault::Unsupported, "PFM is not little-endian");
  if (const auto fits = check_size(*width, *height, max_pixels); !fits) return tl::unexpected(fits.error());

  const std::size_t row_bytes = *width * sizeof(float);
  if (text.size() != *height * row_bytes) return fail(Fault::Malformed, "PFM's pixels do not fill its size");
  Image<float> image({*width, *height});
  const char* row = text.data();
  for (std::uint32_t y = *height; y-- > 0; row += row_bytes) std::memcpy(&image.at(0, y), row, row_bytes);
  return image;
}

}  // namespace farshade
