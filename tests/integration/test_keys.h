/// TestKeys: a key for tests in a client file and a key ring. Both are removed when the test program ends.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

#include "stereo/sealing/key_file.h"

namespace farshade {

struct TestKeys {
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("farshade_keys." + std::to_string(getpid()));
  SharedKey key = new_key("tester").value();
  std::string client = (folder / "client.key").string();
  std::string ring = (folder / "ring.keys").string();

  TestKeys() {
    if (!write_key(client, key) || !append_to_ring(ring, key))
      throw std::runtime_error("no key could be made");
  }
  TestKeys(const TestKeys&) = delete;
  TestKeys& operator=(const TestKeys&) = delete;
  ~TestKeys() {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
};

[[nodiscard]] inline const TestKeys& test_keys() {
  static const TestKeys keys;
  return keys;
}

}  // namespace farshade
