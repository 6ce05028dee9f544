/// Which memory buffers get, on a GPU that lavapipe stands for: with memory of its own, of which the host
/// sees a small part.
#include "stereo/gpu/upload_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

namespace farshade::gpu {
namespace {

using Property = vk::MemoryPropertyFlagBits;
constexpr vk::MemoryPropertyFlags kLocal = Property::eDeviceLocal,
                                  kHost = Property::eHostVisible | Property::eHostCoherent;

struct Heap {
  std::uint64_t mebibytes;
  std::vector<vk::MemoryPropertyFlags> types;
};

vk::PhysicalDeviceMemoryProperties memory_of(const std::vector<Heap>& heaps) {
  vk::PhysicalDeviceMemoryProperties memory{};
  for (const Heap& heap : heaps) {
    for (const vk::MemoryPropertyFlags flags : heap.types)
      memory.memoryTypes[memory.memoryTypeCount++] =
          vk::MemoryType{.propertyFlags = flags, .heapIndex = memory.memoryHeapCount};
    memory.memoryHeaps[memory.memoryHeapCount++].size = heap.mebibytes << 20;
  }
  return memory;
}

const std::vector<Heap> kSmallBar{{8192, {kLocal}}, {16384, {kHost}}, {256, {kLocal | kHost}}};
enum Type : std::uint32_t { kOwn, kHosts, kBar };

/// Every type of memory is lavapipe's only one, but some have none left.
class FakeTypes {
 public:
  explicit FakeTypes(const Device& device) {
    using Functions = std::remove_cvref_t<decltype(*device.logical.getDispatcher())>;
    auto& call = const_cast<Functions&>(*device.logical.getDispatcher());
    asked.clear();
    full.clear();
    allocate_ = call.vkAllocateMemory;
    requirements_ = call.vkGetBufferMemoryRequirements;
    call.vkAllocateMemory = [](VkDevice on, const VkMemoryAllocateInfo* info, const VkAllocationCallbacks* by,
                               VkDeviceMemory* memory) {
      const std::uint32_t type = info->memoryTypeIndex;
      asked.push_back(type);
      if (std::ranges::find(full, type) != full.end()) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
      VkMemoryAllocateInfo real = *info;
      real.memoryTypeIndex = 0;
      return allocate_(on, &real, by, memory);
    };
    call.vkGetBufferMemoryRequirements = [](VkDevice on, VkBuffer buffer, VkMemoryRequirements* needs) {
      requirements_(on, buffer, needs);
      needs->memoryTypeBits = 0b111;
    };
  }
  static inline std::vector<std::uint32_t> asked, full;

 private:
  static inline PFN_vkAllocateMemory allocate_;
  static inline PFN_vkGetBufferMemoryRequirements requirements_;
};

class SmallBar : public testing::Test {
 protected:
  void SetUp() override {
    DeviceOptions lavapipe;  // has one type of memory, which can stand for any
    lavapipe.name_contains = "llvmpipe";
    Expected<Device> opened = open_device(lavapipe);
    if (!opened) GTEST_SKIP() << opened.error().what;
    device_ = std::move(*opened);
    device_.memory = memory_of(kSmallBar);
    frames_.emplace(device_, 2);
    types_.emplace(device_);
  }
  [[nodiscard]] UploadBuffer upload_buffer() {
    return make_upload_buffer(*frames_, 4000, vk::BufferUsageFlagBits::eTransferSrc, "upload");
  }
  using Types = std::vector<std::uint32_t>;

  Device device_;
  std::optional<FramesInFlight> frames_;
  std::optional<FakeTypes> types_;
};

TEST_F(SmallBar, ShadersReadTheDevicesMemoryAndTheHostWritesItsOwn) {
  UploadBuffer upload = upload_buffer();
  EXPECT_EQ(FakeTypes::asked, (Types{kOwn}));
  upload.write(0, 1);
  EXPECT_EQ(FakeTypes::asked, (Types{kOwn, kHosts}));
}

TEST_F(SmallBar, AFullTypeIsFollowedByTheNext) {
  FakeTypes::full = {kOwn};
  const Buffer buffer = make_device_buffer(device_, 4000, vk::BufferUsageFlagBits::eTransferDst, "buffer");
  EXPECT_EQ(FakeTypes::asked, (Types{kOwn, kBar}));
  FakeTypes::full = {kOwn, kHosts, kBar};
  try {
    (void)make_device_buffer(device_, 3 << 20, vk::BufferUsageFlagBits::eTransferDst, "second", Use::Depth);
    FAIL() << "memory was found";
  } catch (const vk::OutOfDeviceMemoryError& error) {
    const std::string what = error.what();
    EXPECT_NE(what.find("vkAllocateMemory for 'second'"), std::string::npos) << what;
    EXPECT_NE(what.find("has no 3 MiB left: fewer pixels an eye"), std::string::npos) << what;
  }
}

TEST_F(SmallBar, TypesThatNeedAFeatureAreLeftOut) {
  device_.memory = memory_of({{8192, {kLocal | Property::eDeviceCoherentAMD, kLocal}}, {16384, {kHost}}});
  (void)make_device_buffer(device_, 4000, vk::BufferUsageFlagBits::eTransferDst, "buffer");
  EXPECT_EQ(FakeTypes::asked, (Types{1}));
}

}  // namespace
}  // namespace farshade::gpu
