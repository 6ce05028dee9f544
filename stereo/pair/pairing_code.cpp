#include "stereo/pair/pairing_code.h"

#include <algorithm>
#include <optional>

#include "stereo/base/digest.h"

namespace farshade {
namespace {

constexpr std::string_view kScheme = "farshade://";
constexpr std::string_view kAlphabet = "0123456789ABCDEFGHJKMNPQRSTVWXYZ";
constexpr std::string_view kKeyLabel = "farshade pairing code 1";
constexpr std::size_t kGroup = 4;
static_assert(kAlphabet.size() == 32);

std::optional<std::uint8_t> symbol_of(char c) {
  if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  if (c == 'I' || c == 'L') c = '1';
  if (c == 'O') c = '0';
  const std::size_t at = kAlphabet.find(c);
  if (at == kAlphabet.npos) return std::nullopt;
  return static_cast<std::uint8_t>(at);
}

}  // namespace

PairingCode new_pairing_code(std::string address) {
  PairingCode code{.address = std::move(address)};
  const SharedKey random = new_key("code").value();
  static_assert(kCodeLength <= sizeof random.secret);
  for (std::size_t i = 0; i < kCodeLength; ++i) code.symbols[i] = random.secret[i] % 32;
  return code;
}

std::string to_string(const PairingCode& code) {
  std::string text = std::string(kScheme) + code.address;
  for (std::size_t i = 0; i < kCodeLength; ++i) {
    if (i % kGroup == 0) text += i == 0 ? '/' : '-';
    text += kAlphabet[code.symbols[i]];
  }
  return text;
}

Expected<PairingCode> parse_pairing_code(std::string_view text) {
  if (text.starts_with(kScheme)) text.remove_prefix(kScheme.size());
  const std::size_t slash = text.find('/');
  if (slash == text.npos || slash == 0)
    return fail(
        Fault::Malformed,
        "a pairing code is HOST/XXXX-XXXX-XXXX-XXXX-XXXX: copy the whole line that rt_server pair prints");
  PairingCode code{.address = std::string(text.substr(0, slash))};
  std::size_t count = 0;
  for (const char c : text.substr(slash + 1)) {
    if (c == '-') continue;
    const std::optional<std::uint8_t> symbol = symbol_of(c);
    if (!symbol)
      return fail(Fault::Malformed,
                  "a pairing code has only letters, digits and hyphens behind the /, and no U");
    if (count < kCodeLength) code.symbols[count] = *symbol;
    ++count;
  }
  if (count != kCodeLength)
    return fail(Fault::Malformed, "the pairing code has " + std::to_string(count) +
                                      " letters and digits of " + std::to_string(kCodeLength) +
                                      " behind the /");
  return code;
}

SharedKey one_time_key(const PairingCode& code) {
  Digester digester;
  digester.add(std::as_bytes(std::span(kKeyLabel)));
  digester.add(std::as_bytes(std::span(code.symbols)));
  return {.name = "pairing", .secret = digester.finish()};
}

}  // namespace farshade
