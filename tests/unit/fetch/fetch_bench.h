/// A scene's files on a server, and a client that fetches them, in one process over loopback.
#pragma once

#include <gtest/gtest.h>

#include <random>

#include "rt_server/fetch/scene_sender.h"
#include "stereo/base/files.h"
#include "tests/support/tcp_proxy.h"
#include "tests/unit/scratch_folder.h"
#include "vr_client/fetch/fetch_scene.h"

namespace farshade {

inline Peer loopback(std::uint16_t port = 0) {
  return {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff, 127, 0, 0, 1}, 0, port};
}

class FetchTest : public testing::Test {
 protected:
  /// Files of random bytes: the first is the scene. They are no scene; the sender does not care.
  void write(const std::vector<std::pair<std::string, std::size_t>>& files) {
    std::mt19937_64 random(7);
    for (const auto& [name, size] : files) {
      std::vector<std::byte> bytes(size);
      for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
      const std::filesystem::path path = folder_.path() / "scene" / name;
      std::filesystem::create_directories(path.parent_path());
      ASSERT_TRUE(write_file_atomically(path, bytes));
      names_.push_back(name);
    }
  }

  /// The files as a loader lists them. Those that are too large to be sent have no digest.
  [[nodiscard]] std::vector<SceneFile> loaded() const {
    std::vector<SceneFile> files;
    for (const std::string& name : names_) {
      const std::filesystem::path path = folder_.path() / "scene" / name;
      const auto bytes = read_file(path, std::uint64_t{1} << 28);
      files.push_back(
          {name, std::filesystem::file_size(path), bytes ? digest_of(*bytes) : Digest{}, changed_at(path)});
    }
    return files;
  }

  void serve(const SenderLimits& limits = {}) { serve(loaded(), limits); }
  void serve(std::vector<SceneFile> files, const SenderLimits& limits) {
    SceneToSend what{.scene = folder_.path() / "scene" / names_.front(),
                     .files = std::move(files),
                     .lighting = {.ambient = 0.25f},
                     .served = {.scene_hash = {1, 2, 3}, .light_count = 2},
                     .ring = {key_}};
    auto listener = TcpListener::listen(loopback()).value();
    server_ = listener.local();
    sender_.emplace(
        std::move(listener), std::move(what), [] { return false; }, limits);
  }

  [[nodiscard]] FetchPlan plan() const {
    return {.servers = {server_},
            .key = key_,
            .cache = folder_.path() / "cache",
            .patience = std::chrono::seconds(60),
            .retry_pause = std::chrono::milliseconds(10)};
  }

  void expect_equal_files(const FetchedScene& fetched) const {
    for (const std::string& name : names_) {
      const auto there = read_file(folder_.path() / "scene" / name, 1 << 30);
      const auto here = read_file(fetched.scene.parent_path() / name, 1 << 30);
      ASSERT_TRUE(there && here) << name;
      EXPECT_TRUE(*there == *here) << name;
    }
  }

  ScratchFolder folder_;
  std::vector<std::string> names_;
  SharedKey key_ = new_key("tester").value();
  Peer server_;
  std::optional<SceneSender> sender_;
};

}  // namespace farshade
