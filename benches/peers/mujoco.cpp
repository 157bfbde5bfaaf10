// Times of MuJoCo, one line a quantity: its name, and microseconds per call or a plain number.
//
//     mujoco_times MODEL.mjb      a model saved by mj_saveModel
//
// The library is the one of the wheel, as its makers compile it.

#include <mujoco/mujoco.h>

#include "timing.hpp"

#include <cmath>
#include <iostream>
#include <random>
#include <vector>

namespace {

struct Point {
  std::vector<double> q, v, u;
};

std::vector<double> random_vector(int n, double reach, std::mt19937& rng) {
  std::uniform_real_distribution<double> uniform(-reach, reach);
  std::vector<double> x(n);
  for (double& entry : x) entry = uniform(rng);
  return x;
}

/// Random states of the robot with the joints within half a turn or 3 m.
std::vector<Point> random_points(const mjModel* model) {
  std::mt19937 rng(1);
  std::vector<Point> points;
  for (int i = 0; i < N_POINTS; ++i) {
    points.push_back({random_vector(model->nq, 3.0, rng), random_vector(model->nv, 1.0, rng),
                      random_vector(model->nu, 1.0, rng)});
    mj_normalizeQuat(model, points.back().q.data());
  }
  return points;
}

void set(const mjModel* model, mjData* data, const Point& p) {
  mju_copy(data->qpos, p.q.data(), model->nq);
  mju_copy(data->qvel, p.v.data(), model->nv);
  mju_copy(data->ctrl, p.u.data(), model->nu);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: mujoco_times MODEL.mjb\n";
    return 2;
  }
  mjModel* model = mj_loadModel(argv[1], nullptr);
  if (!model) {
    std::cerr << argv[1] << " is no model of this version of MuJoCo\n";
    return 1;
  }
  mjData* data = mj_makeData(model);
  const std::vector<Point> points = random_points(model);
  std::vector<double> A(4 * model->nv * model->nv), B(2 * model->nv * model->nu);

  print("nv", model->nv);
  print("nu", model->nu);
  print("mass", mj_getTotalmass(model));
  print("step", median_microseconds([&](int i) {
          set(model, data, points[i]);
          mj_step(model, data);
        }));
  // Forward differences: the cheaper of the two kinds.
  print("transition_fd", median_microseconds([&](int i) {
          set(model, data, points[i]);
          mjd_transitionFD(model, data, 1e-6, 0, A.data(), B.data(), nullptr, nullptr);
        }));
  mj_deleteData(data);
  mj_deleteModel(model);
}
