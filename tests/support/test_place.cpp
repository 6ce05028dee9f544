#include "tests/support/test_place.h"

#include <cstdlib>

namespace farshade {
namespace {

std::string from_environment(const char* variable, const char* otherwise) {
  const char* const value = std::getenv(variable);
  return value != nullptr && *value != '\0' ? value : otherwise;
}

}  // namespace

std::filesystem::path test_root() {
  return from_environment("FARSHADE_TEST_ROOT", FARSHADE_SOURCE);
}

std::string asset(const std::string& file) {
  return test_root() / "assets" / file;
}

std::string shared_scene(const std::string& file) {
  return test_root() / "../shared/scenes" / file;
}

std::string shared_trace(const std::string& file) {
  return test_root() / "../shared/traces" / file;
}

std::filesystem::path test_output() {
  return from_environment("FARSHADE_TEST_OUT", FARSHADE_BINARY);
}

std::string test_gpu() {
  return from_environment("FARSHADE_TEST_GPU", "llvmpipe");
}

}  // namespace farshade
