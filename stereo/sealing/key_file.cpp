#include "stereo/sealing/key_file.h"

#include <sodium.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <map>

#include "stereo/base/check.h"
#include "stereo/base/files.h"
#include "stereo/base/user_folders.h"

namespace farshade {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFormat = "farshade-key-1";
constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kIdLabel = "farshade key id 1";
constexpr std::string_view kNameRule = "a key's name has 1 to 64 of the characters A-Z a-z 0-9 . _ -";
using Secret = decltype(SharedKey::secret);

void start_sodium() {
  check(sodium_init() >= 0, "libsodium starts");
}

bool is_name_character(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '_' ||
         c == '-';
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= kMaxKeyName &&
         std::all_of(name.begin(), name.end(), is_name_character);
}

/// Removes and returns the next word of `line`; empty at its end.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

/// Removes and returns the next line of `text`.
std::string_view take_line(std::string_view& text) {
  const std::string_view line = text.substr(0, text.find('\n'));
  text.remove_prefix(std::min(line.size() + 1, text.size()));
  return line;
}

bool read_secret(std::string_view digits, Secret& secret) {
  std::size_t bytes = 0;
  return digits.size() == 2 * secret.size() &&
         sodium_hex2bin(secret.data(), secret.size(), digits.data(), digits.size(), nullptr, &bytes,
                        nullptr) == 0 &&
         bytes == secret.size();
}

/// A number in digits alone, from `least` to `most`.
std::optional<std::uint64_t> read_number(std::string_view digits, std::uint64_t least, std::uint64_t most) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool whole = error == std::errc() && end == digits.data() + digits.size();
  return whole && value >= least && value <= most ? std::optional(value) : std::nullopt;
}

/// Reads one `NAME=VALUE`. False if it is none, out of range, or there already.
bool read_limit(std::string_view word, KeyLimits& limits) {
  const auto take = [&](std::string_view name, auto& into, const auto& read) {
    if (!word.starts_with(name)) return false;
    if (into) return false;
    into = read(word.substr(name.size()));
    return into.has_value();
  };
  return take("until=", limits.until, parse_day) ||
         take("sessions=", limits.sessions,
              [](std::string_view text) { return read_number(text, 1, KeyLimits::kMostSessions); }) ||
         take("bytes-per-second=", limits.bytes_per_second, [](std::string_view text) {
           return read_number(text, KeyLimits::kLeastBytesPerSecond, KeyLimits::kMostBytesPerSecond);
         });
}

/// Parses a line that is neither blank nor a comment. Errors do not quote it, since it may contain a secret.
Expected<SharedKey> read_key(std::string_view line, const std::string& place) {
  SharedKey key;
  if (const std::string_view format = take_word(line); format != kFormat) {
    if (format.starts_with("farshade-key-"))
      return fail(Fault::Unsupported, place + "a key of another version than " + std::string(kFormat));
    return fail(Fault::Malformed, place + "should be '" + std::string(kFormat) + " NAME SECRET'");
  }
  key.name = take_word(line);
  if (!is_name(key.name)) return fail(Fault::Malformed, place + std::string(kNameRule));
  if (!read_secret(take_word(line), key.secret))
    return fail(Fault::Malformed, place + "the secret should be 64 hexadecimal digits");
  if (sodium_is_zero(key.secret.data(), key.secret.size()) != 0)
    return fail(Fault::Malformed, place + "a secret of zeros is none: make one with rt_server keygen");
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line))
    if (!read_limit(word, key.limits))
      return fail(Fault::Malformed,
                  place +
                      "there is more behind the secret than until=YEAR-MONTH-DAY, sessions=1 to 4096 and "
                      "bytes-per-second=25000 to 10000000000, each once");
  return key;
}

/// The line numbers of names and secrets, to detect duplicates.
class DuplicateCheck {
 public:
  Expected<void> add(const SharedKey& key, std::size_t line, const std::string& place) {
    const auto [name, is_new_name] = names_.emplace(key.name, line);
    if (!is_new_name)
      return fail(Fault::Malformed,
                  place + "the name '" + key.name + "' is already in line " + std::to_string(name->second));
    const auto [secret, is_new_secret] = secrets_.emplace(key.secret, line);
    if (!is_new_secret)
      return fail(Fault::Malformed, place + "the secret of '" + key.name + "' is already in line " +
                                        std::to_string(secret->second));
    return {};
  }

 private:
  std::map<std::string, std::size_t> names_;
  std::map<Secret, std::size_t> secrets_;
};

std::string text_of(std::chrono::sys_days day) {
  const std::chrono::year_month_day date(day);
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02u", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()));
  return text.data();
}

std::string text_of(const KeyLimits& limits) {
  std::string text;
  if (limits.until) text += " until=" + text_of(*limits.until);
  if (limits.sessions) text += " sessions=" + std::to_string(*limits.sessions);
  if (limits.bytes_per_second) text += " bytes-per-second=" + std::to_string(*limits.bytes_per_second);
  return text;
}

/// Text with secrets, which is overwritten when it is no longer needed.
struct SecretText {
  std::string text;
  explicit SecretText(std::string from) : text(std::move(from)) {}
  SecretText(const SecretText&) = delete;
  SecretText& operator=(const SecretText&) = delete;
  SecretText(SecretText&&) = default;
  SecretText& operator=(SecretText&&) = delete;
  ~SecretText() { sodium_memzero(text.data(), text.size()); }
};

Expected<SecretText> read_text(const fs::path& path) {
  return read_private_file(path, kMaxKeyFileBytes).map([](std::vector<std::byte> bytes) {
    SecretText kept(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    sodium_memzero(bytes.data(), bytes.size());
    return kept;
  });
}

/// `ring` with a further line.
SecretText with_line(const SecretText& ring, const SharedKey& key) {
  const SecretText line(key_line(key));
  std::string grown;  // never reallocates, as in key_line
  grown.reserve(ring.text.size() + 1 + line.text.size());
  grown += ring.text;
  if (!ring.text.empty() && ring.text.back() != '\n') grown += '\n';
  grown += line.text;
  return SecretText(std::move(grown));
}

/// Makes the missing folders of `path`, for this user only.
Expected<void> make_folders(const fs::path& path) {
  const fs::path folder = path.parent_path();
  std::error_code error;
  if (folder.empty() || fs::exists(folder, error)) return {};
  if (Expected<void> above = make_folders(folder); !above) return above;
  if (fs::create_directory(folder, error))
    fs::permissions(folder, fs::perms::owner_all, fs::perm_options::replace, error);
  if (!error) return {};
  return fail(Fault::Unreadable, "cannot make the folder '" + folder.string() + "': " + error.message());
}

}  // namespace

SharedKey::~SharedKey() {
  sodium_memzero(secret.data(), secret.size());
}

std::optional<std::chrono::sys_days> parse_day(std::string_view text) {
  const bool shaped = text.size() == 10 && text[4] == '-' && text[7] == '-';
  if (!shaped) return std::nullopt;
  const auto year = read_number(text.substr(0, 4), 1970, 9999), month = read_number(text.substr(5, 2), 1, 12),
             day = read_number(text.substr(8, 2), 1, 31);
  if (!year || !month || !day) return std::nullopt;
  const std::chrono::year_month_day date(std::chrono::year(static_cast<int>(*year)),
                                         std::chrono::month(static_cast<unsigned>(*month)),
                                         std::chrono::day(static_cast<unsigned>(*day)));
  return date.ok() ? std::optional(std::chrono::sys_days(date)) : std::nullopt;
}

bool is_valid_on(const SharedKey& key, std::chrono::sys_days day) {
  return !key.limits.until || day <= *key.limits.until;
}

KeyId id_of(const SharedKey& key) {
  start_sodium();
  std::array<std::uint8_t, 32> hash{};
  static_assert(sizeof hash >= crypto_generichash_BYTES_MIN);
  const int hashed =
      crypto_generichash(hash.data(), hash.size(), reinterpret_cast<const unsigned char*>(kIdLabel.data()),
                         kIdLabel.size(), key.secret.data(), key.secret.size());
  check(hashed == 0, "keyed BLAKE2b");
  KeyId id{};
  std::copy_n(hash.begin(), id.size(), id.begin());
  return id;
}

bool is_sound(const SharedKey& key) {
  return is_name(key.name) && sodium_is_zero(key.secret.data(), key.secret.size()) == 0;
}

KeyRing by_id(const std::vector<SharedKey>& keys) {
  KeyRing ring;
  for (const SharedKey& key : keys) ring.emplace(id_of(key), key);
  return ring;
}

Expected<SharedKey> new_key(std::string_view name) {
  if (!is_name(name)) return fail(Fault::OutOfRange, std::string(kNameRule));
  start_sodium();
  SharedKey key{std::string(name), {}};
  randombytes_buf(key.secret.data(), key.secret.size());
  return key;
}

Expected<std::vector<SharedKey>> parse_keys(std::string_view text, std::string_view where) {
  const std::string file(where);
  if (text.size() > kMaxKeyFileBytes)
    return fail(Fault::OutOfRange, file + ": more than " + std::to_string(kMaxKeyFileBytes) + " bytes");
  std::vector<SharedKey> keys;
  DuplicateCheck duplicates;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = take_line(text);
    const std::size_t first = line.find_first_not_of(kBlanks);
    if (first == std::string_view::npos || line[first] == '#') continue;
    const std::string place = file + ":" + std::to_string(number) + ": ";
    Expected<SharedKey> key = read_key(line, place);
    if (!key) return tl::unexpected(key.error());
    if (const Expected<void> added = duplicates.add(*key, number, place); !added)
      return tl::unexpected(added.error());
    if (keys.size() == kMaxRingKeys)
      return fail(Fault::OutOfRange, place + "more than " + std::to_string(kMaxRingKeys) + " keys");
    keys.push_back(*std::move(key));
  }
  return keys;
}

std::string key_line(const SharedKey& key) {
  check(is_name(key.name), "a key has a name");
  std::array<char, 2 * sizeof key.secret + 1> digits{};
  sodium_bin2hex(digits.data(), digits.size(), key.secret.data(), key.secret.size());
  const std::string limits = text_of(key.limits);
  std::string line;  // never reallocates, so no copy of the digits stays behind
  line.reserve(kFormat.size() + key.name.size() + digits.size() + limits.size() + 2);
  line.append(kFormat).append(" ").append(key.name).append(" ").append(digits.data());
  sodium_memzero(digits.data(), digits.size());
  line.append(limits).append("\n");
  return line;
}

Expected<SharedKey> load_key(const fs::path& path) {
  Expected<std::vector<SharedKey>> keys = load_key_ring(path);
  if (!keys) return tl::unexpected(keys.error());
  if (keys->size() != 1)
    return fail(Fault::Malformed,
                path.string() + ": " + std::to_string(keys->size()) + " keys where one should be");
  return std::move(keys->front());
}

Expected<std::vector<SharedKey>> load_key_ring(const fs::path& path) {
  return read_text(path).and_then(
      [&](const SecretText& ring) { return parse_keys(ring.text, path.string()); });
}

Expected<void> write_key(const fs::path& path, const SharedKey& key) {
  return make_folders(path).and_then(
      [&] { return write_private_file(path, SecretText(key_line(key)).text, IfThere::Refuse); });
}

Expected<void> append_to_ring(const fs::path& link, const SharedKey& key) {
  std::error_code unresolved;
  fs::path path = fs::weakly_canonical(link, unresolved);
  if (unresolved) path = link;
  if (Expected<void> made = make_folders(path); !made) return made;
  const Expected<FolderLock> lock = FolderLock::of(path.parent_path());
  if (!lock) return tl::unexpected(lock.error());
  const Expected<SecretText> ring = read_text(path);
  if (!ring && ring.error().fault == Fault::Missing) return write_key(path, key);
  if (!ring) return tl::unexpected(ring.error());
  const Expected<std::vector<SharedKey>> keys = parse_keys(ring->text, path.string());
  if (!keys) return tl::unexpected(keys.error());
  for (const SharedKey& there : *keys)
    if (there.name == key.name || there.secret == key.secret)
      return fail(Fault::Unavailable,
                  path.string() + ": " +
                      (there.name == key.name ? "has a key named '" : "has the secret of '") + key.name +
                      "' already");
  const SecretText grown = with_line(*ring, key);
  if (grown.text.size() > kMaxKeyFileBytes || keys->size() == kMaxRingKeys)
    return fail(Fault::OutOfRange, path.string() + ": the ring is full");
  return write_private_file(path, grown.text, IfThere::Replace);
}

fs::path default_key_path() {
  return config_folder() / "client.key";
}

fs::path default_ring_path() {
  return config_folder() / "ring.keys";
}

}  // namespace farshade
