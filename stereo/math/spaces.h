/// Coordinate spaces as types: a point has a space, and a transform has a source and a target space. Names
/// read right to left and adjacent names cancel: `stage_from_eye * eye_from_object` is stage_from_object. All
/// values are double, in metres. Shaders get camera-relative floats.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

namespace farshade {

struct Stage;     ///< the fixed, gravity-aligned world: +x right, +y up, -z ahead, right-handed
struct Head;      ///< the head, with its origin between the eyes
struct Eye;       ///< one eye: +x right, +y up, -z ahead
struct Object;    ///< the space of a mesh in its file
struct Recorded;  ///< the stage of a head recording, before it is placed in a scene

template <class Space>
struct Vector {
  glm::dvec3 v{0.0};
  friend bool operator==(const Vector&, const Vector&) = default;
};

template <class Space>
struct Point {
  glm::dvec3 v{0.0};
  friend bool operator==(const Point&, const Point&) = default;
};

template <class S>
Vector<S> operator-(Point<S> a, Point<S> b) {
  return {a.v - b.v};
}
template <class S>
Point<S> operator+(Point<S> p, Vector<S> d) {
  return {p.v + d.v};
}
template <class S>
Point<S> operator-(Point<S> p, Vector<S> d) {
  return {p.v - d.v};
}
template <class S>
Vector<S> operator+(Vector<S> a, Vector<S> b) {
  return {a.v + b.v};
}
template <class S>
Vector<S> operator*(Vector<S> a, double s) {
  return {a.v * s};
}
template <class S>
double length(Vector<S> a) {
  return glm::length(a.v);
}

/// A rotation, then a translation: p_To = rotation * p_From + translation. `rotation` is unit.
template <class To, class From>
struct Rigid {
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};  ///< (w, x, y, z)
  glm::dvec3 translation{0.0};              ///< the origin of From in To

  Point<To> operator()(Point<From> p) const { return {rotation * p.v + translation}; }
  Vector<To> operator()(Vector<From> d) const { return {rotation * d.v}; }

  template <class Further>
  Rigid<To, Further> operator*(const Rigid<From, Further>& b) const {
    return {glm::normalize(rotation * b.rotation), rotation * b.translation + translation};
  }
  friend bool operator==(const Rigid& a, const Rigid& b) {
    return a.rotation == b.rotation && a.translation == b.translation;
  }
};

template <class To, class From>
Rigid<From, To> inverse(const Rigid<To, From>& t) {
  const glm::dquat back = glm::conjugate(t.rotation);
  return {back, back * -t.translation};
}

template <class To, class From>
glm::dmat4 matrix(const Rigid<To, From>& t) {
  glm::dmat4 m = glm::mat4_cast(t.rotation);
  m[3] = glm::dvec4(t.translation, 1.0);
  return m;
}

/// An invertible affine map, as glTF nodes have (scale, negative scale, shear).
template <class To, class From>
struct Affine {
  glm::dmat4 matrix{1.0};  ///< last row 0 0 0 1

  Point<To> operator()(Point<From> p) const { return {glm::dvec3(matrix * glm::dvec4(p.v, 1.0))}; }
  Vector<To> operator()(Vector<From> d) const { return {glm::dmat3(matrix) * d.v}; }
  template <class Further>
  Affine<To, Further> operator*(const Affine<From, Further>& b) const {
    return {matrix * b.matrix};
  }
  friend bool operator==(const Affine&, const Affine&) = default;
};

template <class To, class From, class Further>
Affine<To, Further> operator*(const Rigid<To, From>& a, const Affine<From, Further>& b) {
  return {matrix(a) * b.matrix};
}

}  // namespace farshade
