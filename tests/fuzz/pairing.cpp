// Pairing: a code that a person types and the messages of both sides. What is read can be put into a ring,
// and reads back the same after writing. A refused code is one plain line.
#include "stereo/pair/pairing_code.h"
#include "stereo/pair/pairing_messages.h"
#include "tests/fuzz/target.h"

using namespace farshade;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  if (const auto key = decode_pairing_request(bytes)) {
    const auto ring = parse_keys(key_line(*key), "ring");
    check(ring && ring->size() == 1 && ring->front() == *key, "a key that came fits into a ring");
    check(encode_pairing_request(*key) == std::vector(bytes.begin(), bytes.end()), "the same bytes again");
  }
  if (const auto answer = decode_pairing_answer(bytes))
    check(encode(*answer) == std::vector(bytes.begin(), bytes.end()), "the same bytes again");
  const auto code = parse_pairing_code(fuzz::text_of(data, size));
  if (!code) {
    for (const char c : code.error().what) check(c >= ' ' && c <= '~', "a refusal is one plain line");
    return 0;
  }
  const auto again = parse_pairing_code(to_string(*code));
  check(again && *again == *code, "a written code reads back the same");
  return 0;
}
