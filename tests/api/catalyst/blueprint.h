// What tests of Blueprint's nodes share: a session, and the box of nodes.h as a tree of each kind.
#pragma once

#include <array>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "insitu/blueprint.h"
#include "insitu/insitu.hpp"

#include "nodes.h"

/// A uniform block as the domain of this path, such as "a/"; "": of the node itself.
inline void add_uniform(TestNode& node, const std::string& domain, const std::vector<int>& cells,
                        const std::vector<double>& origin, const std::vector<double>& spacing) {
  for (std::size_t a = 0; a < cells.size(); ++a) {
    node.set(domain + "coordsets/coords/dims/" + "ijk"[a], cells[a] + 1);
    node.set(domain + "coordsets/coords/origin/" + "xyz"[a], origin[a]);
    node.set(domain + "coordsets/coords/spacing/d" + "xyz"[a], spacing[a]);
  }
  node.set(domain + "coordsets/coords/type", "uniform");
  node.set(domain + "topologies/topo/type", "uniform");
  node.set(domain + "topologies/topo/coordset", "coords");
}

class Blueprint : public testing::Test {
protected:
  ~Blueprint() override { insitu_blueprint_release(&blueprint_); }

  insitu_status attach(const TestNode& node, bool adaptive = false) {
    insitu_blueprint_options options = insitu_blueprint_options_default();
    options.adaptive = adaptive;
    return insitu_blueprint_attach(session_.handle(), "mesh", node.get(), &options, &blueprint_);
  }
  void expect_attached(const TestNode& node, bool adaptive = false) {
    ASSERT_EQ(attach(node, adaptive), INSITU_OK) << insitu_blueprint_message();
    session_.mesh("mesh").commit();
  }
  /// The centres of the box's cells, shifted a little.
  static std::vector<double> points_of(const Box& box) {
    std::vector<double> out;
    for (int k = 0; k < box.n[2]; ++k)
      for (int j = 0; j < box.n[1]; ++j)
        for (int i = 0; i < box.n[0]; ++i)
          for (const double c : {Box::at(0, i) + 0.4, Box::at(1, j) + 0.3, Box::at(2, k) + 0.1})
            out.push_back(c);
    return out;
  }
  /// Every cell is found, f is linear, and the cells' numbers are theirs.
  void expect_box(const Box& box) {
    insitu::Mesh mesh = session_.mesh("mesh");
    const std::vector<double> points = points_of(box);
    const insitu::Samples f = mesh.sample("f", points), number = mesh.sample("number", points);
    ASSERT_EQ(f.size(), std::size_t(box.own_cells()));
    for (std::size_t p = 0; p < f.size(); ++p) {
      ASSERT_TRUE(f.found[p]) << "point " << p;
      // Roundings of eight products and sums of numbers below 32.
      EXPECT_NEAR(f(p), points[3 * p] + 2 * points[3 * p + 1] + 3 * points[3 * p + 2], 1e-12);
      EXPECT_EQ(number(p), double(p));
    }
  }
  void expect_in_place() {
    for (const insitu::AuditEntry& e : session_.mesh("mesh").audit())
      EXPECT_TRUE(e.borrowed) << e.name;
  }
  std::size_t copies() {
    std::size_t n = 0;
    for (const insitu::AuditEntry& e : session_.mesh("mesh").audit())
      n += !e.borrowed;
    return n;
  }
  void expect_refused(const TestNode& node, insitu_status status, const std::string& text,
                      bool adaptive = false) {
    EXPECT_EQ(attach(node, adaptive), status);
    EXPECT_NE(std::string(insitu_blueprint_message()).find(text), std::string::npos)
        << insitu_blueprint_message();
  }

  static void add_fields(TestNode& node, Box& box) {
    node.set("fields/f/association", "vertex").set("fields/f/topology", "topo");
    node.set("fields/f/values", box.f);
    node.set("fields/number/association", "element").set("fields/number/topology", "topo");
    node.set("fields/number/values", box.number);
  }
  static void add_topology(TestNode& node, const char* coordset, const char* topology) {
    node.set("coordsets/coords/type", coordset).set("topologies/topo/type", topology);
    node.set("topologies/topo/coordset", "coords");
  }
  static TestNode explicit_box(Box& box, const char* topology) {
    TestNode node;
    add_topology(node, "explicit", topology);
    node.set("coordsets/coords/values/x", box.x).set("coordsets/coords/values/y", box.y);
    node.set("coordsets/coords/values/z", box.z);
    add_fields(node, box);
    return node;
  }
  static TestNode hexahedra(Box& box) {
    TestNode node = explicit_box(box, "unstructured");
    node.set("topologies/topo/elements/shape", "hex");
    node.set("topologies/topo/elements/connectivity", box.hexahedra);
    return node;
  }
  static void add_uniform_box(TestNode& node, const std::string& domain, const Box& box,
                              const std::vector<double>& origin) {
    std::vector<double> spacing;
    for (int a = 0; a < 3; ++a)
      spacing.push_back(Box::at(std::size_t(a), 1) - Box::at(std::size_t(a), 0));
    add_uniform(node, domain, {box.n.begin(), box.n.end()}, origin, spacing);
  }
  static TestNode uniform(Box& box, const std::vector<double>& origin = {1, 2, 3}) {
    TestNode node;
    add_uniform_box(node, "", box, origin);
    add_fields(node, box);
    return node;
  }

  insitu::Options options_ = [] {
    insitu::Options o;
    o.log = [](insitu::LogLevel, const char*) {};
    return o;
  }();
  insitu::Session session_{options_};
  insitu_blueprint blueprint_ = nullptr;
};
