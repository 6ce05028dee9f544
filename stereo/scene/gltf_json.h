/// Access to the members of a JSON object that passed the schema check: the types are known to be right, and
/// a member that is missing has a default value.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "stereo/scene/gltf_document.h"

namespace farshade::gltf {

using nlohmann::json;

/// The member `name`, or a null value.
[[nodiscard]] inline const json& member(const json& object, std::string_view name) {
  static const json none;
  const auto found = object.find(name);
  return found == object.end() ? none : *found;
}

/// The member `name`, or `otherwise`.
template <class T>
[[nodiscard]] T value_or(const json& object, std::string_view name, T otherwise) {
  const json& value = member(object, name);
  return value.is_null() ? otherwise : value.get<T>();
}

[[nodiscard]] inline Index index_in(const json& object, std::string_view name) {
  const json& value = member(object, name);
  return value.is_null() ? Index{} : Index{value.get<std::uint32_t>()};
}

[[nodiscard]] inline std::string text_in(const json& object, std::string_view name,
                                         const char* otherwise = "") {
  return value_or<std::string>(object, name, otherwise);
}

/// The elements of the array `name`; none if it is missing.
[[nodiscard]] inline const json::array_t& list_in(const json& object, std::string_view name) {
  static const json::array_t none;
  const json& value = member(object, name);
  return value.is_null() ? none : value.get_ref<const json::array_t&>();
}

/// The object `extensions.name`, or a null value.
[[nodiscard]] inline const json& extension_in(const json& object, std::string_view name) {
  static const json none;
  const json& extensions = member(object, "extensions");
  return extensions.is_null() ? none : member(extensions, name);
}

}  // namespace farshade::gltf
