#include "stereo/gltf/gltf_files.h"

#include <sodium/utils.h>

#include <algorithm>
#include <charconv>

#include "stereo/base/files.h"
#include "stereo/gltf/gltf_model.h"

namespace farshade::gltf {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
constexpr std::uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinChunk = 0x004E4942;

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct Chunk {
  std::uint32_t kind = 0;
  std::span<const std::byte> payload;
};

/// Removes the first chunk from `rest` and returns it.
Expected<Chunk> take_chunk(std::span<const std::byte>& rest, Repairs& repairs) {
  if (rest.size() < kChunkHeaderBytes) return malformed("GLB: a chunk header is cut off");
  const std::uint64_t length = u32_at(rest, 0);
  if (length > rest.size() - kChunkHeaderBytes)
    return malformed("GLB: a chunk says " + std::to_string(length) + " bytes, the file has " +
                     std::to_string(rest.size() - kChunkHeaderBytes) + " left");
  if (length % 4 != 0) repairs.add(kReadAnyway, "GLB: a chunk does not end at a multiple of 4 bytes");
  const Chunk chunk{u32_at(rest, 4), rest.subspan(kChunkHeaderBytes, length)};
  rest = rest.subspan(kChunkHeaderBytes + length);
  return chunk;
}

Expected<Container> open_glb(std::span<const std::byte> file) {
  if (file.size() < kHeaderBytes) return malformed("GLB: the header is cut off");
  if (const auto version = u32_at(file, 4); version != 2)
    return fail(Fault::Unsupported, "GLB: version " + std::to_string(version) + ", only 2 is read");
  auto rest = file.subspan(kHeaderBytes);
  Container container;
  const std::size_t length = u32_at(file, 8);
  if (length != file.size())
    container.repairs.add(kReadAnyway, "GLB: the header says " + std::to_string(length) +
                                           " bytes, the file has " + std::to_string(file.size()));
  const auto json = take_chunk(rest, container.repairs);
  if (!json) return tl::unexpected(json.error());
  if (json->kind != kJsonChunk) return malformed("GLB: the first chunk is not JSON");
  container.json = text_of(json->payload);
  if (rest.size() < kChunkHeaderBytes || file.size() - rest.size() == length) return container;
  const auto bin = take_chunk(rest, container.repairs);
  if (!bin) return tl::unexpected(bin.error());
  if (bin->kind == kBinChunk) container.bin = bin->payload;
  return container;
}

/// Takes away what JSON text must not have: a byte order mark before it, and zero bytes after it.
Expected<Container> trimmed(Container container) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  std::string_view& json = container.json;
  if (json.starts_with("\xff\xfe") || json.starts_with("\xfe\xff"))
    return fail(Fault::Unsupported, "the JSON text is UTF-16: save it as UTF-8");
  if (json.starts_with(kMark)) {
    container.repairs.add("it is skipped", "the JSON text begins with a byte order mark");
    json.remove_prefix(kMark.size());
  }
  if (json.ends_with('\0')) {
    container.repairs.add("they are skipped", "the JSON text ends with zero bytes");
    json = json.substr(0, json.find_last_not_of('\0') + 1);
  }
  return container;
}

/// Replaces percent escapes by their bytes. Anything else stays unchanged.
std::string percent_decoded(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::uint8_t value = 0;
    const char* digits = text.data() + i + 1;
    const bool is_escape = text[i] == '%' && i + 2 < text.size() &&
                           std::from_chars(digits, digits + 2, value, 16).ptr == digits + 2;
    result += is_escape ? static_cast<char>(value) : text[i];
    if (is_escape) i += 2;
  }
  return result;
}

std::string in_lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
  return result;
}

/// The bytes of "data:[media type];base64,DATA". The padding of DATA may be missing.
Expected<std::vector<std::uint8_t>> decode_data_uri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == uri.npos || !in_lower_case(uri.substr(0, comma)).ends_with(";base64"))
    return malformed("a data URI is not base64");
  std::string_view text = uri.substr(comma + 1);
  const std::string decoded = text.find('%') == text.npos ? "" : percent_decoded(text);
  if (!decoded.empty()) text = decoded;
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
  std::vector<std::uint8_t> bytes(text.size() / 4 * 3 + 2);
  std::size_t size = 0;
  if (sodium_base642bin(bytes.data(), bytes.size(), text.data(), text.size(), nullptr, &size, nullptr,
                        sodium_base64_VARIANT_ORIGINAL_NO_PADDING) != 0)
    return malformed("the base64 text of a data URI is damaged");
  if (size == 0) return malformed("a data URI is empty");
  bytes.resize(size);
  return bytes;
}

}  // namespace

bool is_data_uri(std::string_view uri) {
  return in_lower_case(uri.substr(0, 5)) == "data:";
}

Expected<std::vector<std::uint8_t>> SceneFolder::load(const std::string& uri) {
  if (is_data_uri(uri)) return decode_data_uri(uri);
  const Expected<std::vector<std::byte>> bytes = read(percent_decoded(uri));
  if (!bytes) return tl::unexpected(bytes.error());
  if (bytes->empty()) return malformed("external file '" + printable(uri) + "': it is empty");
  const auto* first = reinterpret_cast<const std::uint8_t*>(bytes->data());
  return std::vector<std::uint8_t>(first, first + bytes->size());
}

Expected<std::vector<std::byte>> SceneFolder::read(const std::string& path) {
  const std::string name = "external file '" + printable(path) + "'";
  if (folder_.empty()) return fail(Fault::Missing, name + ": a scene in memory has no folder");
  if (path.empty() || path.find('\0') != std::string::npos) return malformed(name + ": no file name");
  const fs::path relative(path);
  const bool climbs = std::find(relative.begin(), relative.end(), "..") != relative.end();
  if (relative.is_absolute() || climbs || path.find(':') != std::string::npos)
    return fail(Fault::Unsupported, name + ": only files in the scene's folder are opened");
  std::error_code error;
  const fs::path folder = fs::canonical(folder_, error);
  if (error) return fail(Fault::Missing, folder_.string() + ": " + error.message());
  const fs::path file = fs::weakly_canonical(folder / relative, error);
  if (error) return fail(Fault::Unreadable, name + ": " + error.message());
  if (std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first != folder.end())
    return fail(Fault::Unsupported, name + ": a link leads out of the scene's folder");
  const std::int64_t changed_ns = changed_at(file);
  auto bytes = read_file(file, left_bytes_);
  if (!bytes) return fail(bytes.error().fault, name + ": " + bytes.error().what);
  left_bytes_ -= bytes->size();
  if (list_ == ListFiles::No) return bytes;
  const std::string normal = relative.lexically_normal().generic_string();
  const SceneFile read{normal, bytes->size(), digest_of(*bytes), changed_ns};
  if (files_.try_emplace(normal, read).first->second.digest != read.digest)
    return fail(Fault::Mismatch, name + " was changed while the scene was loaded: load it again");
  return bytes;
}

std::vector<SceneFile> SceneFolder::files() const {
  std::vector<SceneFile> result;
  for (const auto& [name, file] : files_) result.push_back(file);
  return result;
}

Expected<Container> open_container(std::span<const std::byte> file) {
  const bool is_glb = file.size() >= 4 && u32_at(file, 0) == kMagic;
  auto container =
      (is_glb ? open_glb(file) : Expected<Container>(Container{text_of(file)})).and_then(trimmed);
  if (!container || is_glb) return container;
  const auto first = container->json.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos || container->json[first] != '{')
    return malformed("neither a GLB nor a glTF JSON text");
  return container;
}

Expected<void> check_json_depth(std::string_view json, std::uint32_t most) {
  std::uint32_t depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if ((c == '{' || c == '[') && ++depth > most) {
      return malformed("JSON nested deeper than " + std::to_string(most) + " levels");
    } else if ((c == '}' || c == ']') && depth > 0) {
      --depth;
    }
  }
  return {};
}

}  // namespace farshade::gltf
