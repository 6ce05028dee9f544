// Key files: a text is refused in one sentence, or it decodes to keys that read back the same after writing.
#include "stereo/sealing/key_file.h"

#include <set>

#include "tests/fuzz/target.h"

using namespace farshade;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto keys = parse_keys(fuzz::text_of(data, size), "fuzzed");
  if (!keys) {
    check(keys.error().what.starts_with("fuzzed:"), "a refusal names the file");
    for (const char c : keys.error().what) check(c >= ' ' && c <= '~', "a refusal is one plain line");
    return 0;
  }
  std::string text;
  std::set<std::string> names;
  std::set<KeyId> ids;
  for (const SharedKey& key : *keys) {
    text += key_line(key);
    names.insert(key.name);
    ids.insert(id_of(key));
  }
  check_eq(names.size(), keys->size(), "names");
  check_eq(ids.size(), keys->size(), "key ids");
  const auto again = parse_keys(text, "again");
  check(again && *again == *keys, "written keys read back the same");
  return 0;
}
