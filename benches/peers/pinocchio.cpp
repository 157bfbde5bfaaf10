// Times of Pinocchio, one line a quantity: its name, and microseconds per call or a plain number.
//
//     pinocchio_times MODEL.txt      a model saved by Model::saveToText
//
// Everything is instantiated here, from the headers, so that all of it is compiled for the machine's own instruction set; the
// libraries of the wheel are not. For the same reason the model comes as text: objects of Eigen must not pass between code that
// was compiled for different vector units, since these decide their alignment.

#include "pinocchio/multibody.hpp"
#include "pinocchio/serialization.hpp"
#include "pinocchio/algorithm/aba-derivatives.hpp"
#include "pinocchio/algorithm/aba.hpp"
#include "pinocchio/algorithm/crba.hpp"
#include "pinocchio/algorithm/joint-configuration.hpp"
#include "pinocchio/algorithm/rnea-derivatives.hpp"
#include "pinocchio/algorithm/rnea.hpp"

#include "timing.hpp"

#include <iostream>
#include <string>
#include <vector>

namespace {

using Eigen::VectorXd;
using pinocchio::Convention;
using pinocchio::Data;
using pinocchio::Model;

struct Point {
  VectorXd q, v, a, tau;
};

/// Random states of the robot with the joints within half a turn or 3 m.
std::vector<Point> random_points(Model model) {
  model.lowerPositionLimit.setConstant(-3.0);
  model.upperPositionLimit.setConstant(3.0);
  std::vector<Point> points;
  for (int i = 0; i < N_POINTS; ++i) {
    const auto random = [&] { return VectorXd::Random(model.nv).eval(); };
    points.push_back({pinocchio::randomConfiguration(model), random(), random(), random()});
  }
  return points;
}

double total_mass(const Model& model) {
  double mass = 0.0;
  for (std::size_t i = 1; i < model.inertias.size(); ++i) mass += model.inertias[i].mass();
  return mass;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: pinocchio_times MODEL.txt\n";
    return 2;
  }
  Model model;
  pinocchio::serialization::loadFromText(model, std::string(argv[1]));
  Data data(model);
  const std::vector<Point> points = random_points(model);
  const auto time = [&](const char* name, auto&& function) {
    print(name, median_microseconds([&](int i) { function(points[i]); }));
  };

  print("nv", model.nv);
  print("mass", total_mass(model));
  time("rnea", [&](const Point& p) { rnea(model, data, p.q, p.v, p.a); });
  time("crba_world", [&](const Point& p) { crba(model, data, p.q, Convention::WORLD); });
  time("crba_local", [&](const Point& p) { crba(model, data, p.q, Convention::LOCAL); });
  time("aba_world", [&](const Point& p) { aba(model, data, p.q, p.v, p.tau, Convention::WORLD); });
  time("aba_local", [&](const Point& p) { aba(model, data, p.q, p.v, p.tau, Convention::LOCAL); });
  time("rnea_derivatives", [&](const Point& p) { computeRNEADerivatives(model, data, p.q, p.v, p.a); });
  time("aba_derivatives", [&](const Point& p) { computeABADerivatives(model, data, p.q, p.v, p.tau); });
}
