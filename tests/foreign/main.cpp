/// Says how much memory a tracer of a scene takes. It compiles only if the options of the libraries do not
/// reach it: each warning here would be an error with them.
#include <cstdio>

#include "stereo/gltf/gltf.h"
#include "stereo/tracer/tracer_memory.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const auto scene = farshade::load_scene(arguments[1]);
  if (!scene) return 1;
  const int bytes =
      farshade::estimated_memory(*scene, farshade::plan_for(*scene).trace).total();  // -Wconversion
  const int count_of_nobody = 0;                                                     // -Wunused-variable
  {
    const int bytes = 1;  // -Wshadow, -Wunused-variable
  }
  std::printf("%d bytes\n", bytes);
  return bytes > 0 ? 0 : 1;
}
