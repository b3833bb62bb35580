// insitu-bench methods: answers and counts of every method that is here; times and rates are looked
// at only for being there.
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "program.h"

using insitu::test::number;
using insitu::test::Outcome;
using insitu::test::run;

namespace {

/// Where the row of that mesh and method begins in the JSON, or npos.
std::size_t row(const std::string& json, const std::string& mesh, const std::string& backend,
                const std::string& method) {
  return json.find("{\"shape\": \"" + mesh + "\", \"backend\": \"" + backend +
                   "\", \"method\": \"" + method + "\"");
}

const char* const ray_methods[] = {"user_geometry", "replicated_faces", "shared_faces",
                                   "shared_bilinear_faces"};

TEST(BenchMethods, CheckFindsNoDisagreementAndRaysThatAnswer) {
  const Outcome r =
      run("methods --check --cells 3000 --points 4000 --backend cpu --json -", "2>/dev/null");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  for (const std::string mesh :
       {"tet", "hex", "wedge", "mixed", "pyramid", "hex, twisted", "hex, some folded"})
    for (const char* method : ray_methods) {
      const std::string what = mesh + ", " + method;
      const std::size_t at = row(r.out, mesh, "cpu", method);
      ASSERT_NE(at, std::string::npos) << what << "\n" << r.out;
      for (const char* key : {"other_exact", "boundary_other_exact", "other_standard"})
        EXPECT_EQ(number(r.out, key, at), 0.0) << what << ' ' << key;
      EXPECT_EQ(number(r.out, "random_points", at), 4000.0) << what;
      EXPECT_GT(number(r.out, "boundary_points", at), 300.0) << what;
      // What agrees, because the tree answered it, says nothing of the rays.
      const double kept = number(r.out, "exact_kept", at),
                   neighbour = number(r.out, "exact_by_neighbour", at),
                   tree = number(r.out, "exact_by_tree", at);
      EXPECT_EQ(kept + neighbour + tree, 4000.0) << what;
      EXPECT_EQ(number(r.out, "exact_on_host", at), 0.0) << what;
      if (mesh == "hex, some folded") // where certificates prove nothing
        EXPECT_EQ(tree, 4000.0) << what;
      else // flat triangles miss a fifth of the twisted cells, a twentieth of others
        EXPECT_GT(kept, (mesh == "hex, twisted" ? 0.75 : 0.9) * 4000) << what;
    }
}

TEST(BenchMethods, TablesHaveEveryMethodAndSayWhatIsNotHere) {
  const Outcome r =
      run("methods --cells 1000 --points 1000 --repetitions 1 --shape hex", "2>/dev/null");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  for (const char* text :
       {"Memory (Morrical 2020, table 1)", "finding faces", "Uniform (table 2)", "Random (table 3)",
        "Points answered otherwise than by exact bvh", "How those random points were answered",
        "kept by neighbour      by tree      by host", "cpu bvh"})
    EXPECT_NE(r.out.find(text), std::string::npos) << text << "\n" << r.out;
  for (const char* method : ray_methods)
    EXPECT_NE(r.out.find(std::string("cpu ") + method), std::string::npos) << method;
  // auto, with the reason, for either place of a mesh.
  EXPECT_NE(r.out.find("auto, mesh in host memory: cpu bvh (the mesh lies in host memory; bvh is "
                       "fastest on a CPU)"),
            std::string::npos)
      << r.out;
  const std::size_t device = r.out.find("auto, mesh in device memory: ");
  ASSERT_NE(device, std::string::npos);
  const bool cuda = r.out.find("Not here: cuda, ") == std::string::npos;
  EXPECT_EQ(
      r.out.compare(device + 29, cuda ? 9 : 23, cuda ? "cuda bvh " : "locator: backend cuda: "), 0)
      << r.out;
  // Energy: figures, or a line that says why not, for the processor and for the card.
  EXPECT_NE(r.out.find("Energy (section 9.4)"), std::string::npos);
  const std::size_t energy = r.out.find("Energy (section 9.4)");
  const std::string rest = r.out.substr(energy);
  EXPECT_TRUE(rest.find("  Processor: ") != std::string::npos ||
              rest.find("cpu bvh") != std::string::npos)
      << rest;
  EXPECT_TRUE(rest.find("  Card: ") != std::string::npos || cuda) << rest;
}

TEST(BenchMethods, JsonHasTheFacesSecondsOfFaceMethodsAlone) {
  const Outcome r =
      run("methods --cells 1000 --points 500 --repetitions 1 --shape tet --backend cpu --json -",
          "2>/dev/null");
  ASSERT_EQ(r.exit_code, 0) << r.out;
  for (const std::string method :
       {"bvh", "user_geometry", "replicated_faces", "shared_faces", "shared_bilinear_faces"}) {
    const std::size_t at = row(r.out, "tet", "cpu", method);
    ASSERT_NE(at, std::string::npos) << method;
    const bool faces = method.find("faces") != std::string::npos;
    EXPECT_EQ(number(r.out, "faces_s", at) > 0.0, faces) << method;
    EXPECT_GE(number(r.out, "build_s", at), number(r.out, "faces_s", at)) << method;
    for (const char* key : {"uniform_fast_ids", "random_exact_vertex_value", "refit_s", "bytes"})
      EXPECT_GT(number(r.out, key, at), 0.0) << method << ' ' << key;
  }
}

} // namespace
