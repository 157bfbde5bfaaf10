// Writes C that CasADi makes of Pinocchio's templates, for `generated.py`.
//
//     casadi_code MODEL.txt NAME FOLDER      a model saved by Model::saveToText
//
// FOLDER gets NAME_FUNCTION.c for each function below; one line a function is printed: its name and how many operations it has.
// Derivatives come in both ways that one would take: Pinocchio's own algorithms over expressions ("recursive"), and CasADi's differentiation of
// RNEA and ABA ("automatic").

#include "pinocchio/autodiff/casadi.hpp"

#include "pinocchio/multibody.hpp"
#include "pinocchio/serialization.hpp"
#include "pinocchio/algorithm/aba-derivatives.hpp"
#include "pinocchio/algorithm/aba.hpp"
#include "pinocchio/algorithm/joint-configuration.hpp"
#include "pinocchio/algorithm/rnea-derivatives.hpp"
#include "pinocchio/algorithm/rnea.hpp"

#include <iostream>
#include <string>
#include <vector>

namespace {

using casadi::SX;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<SX, Eigen::Dynamic, Eigen::Dynamic>;
using Model = pinocchio::ModelTpl<SX>;
using Data = pinocchio::DataTpl<SX>;

/// Expressions in both forms.
struct Variable {
  SX symbols;
  Vector entries;

  Variable(const std::string& name, int n) : symbols(SX::sym(name, n)), entries(n) {
    for (int i = 0; i < n; ++i) entries[i] = symbols(i);
  }
};

SX expressions(const Matrix& from) {
  SX to(from.rows(), from.cols());
  for (int j = 0; j < from.cols(); ++j)
    for (int i = 0; i < from.rows(); ++i) to(i, j) = from(i, j);
  return to;
}

/// The writer of one function after the other.
struct Writer {
  std::string robot, folder;

  void write(const std::string& what, const std::vector<SX>& in, const std::vector<SX>& out) const {
    const std::string name = robot + "_" + what;
    const casadi::Function function(name, in, out);
    casadi::CodeGenerator code(name + ".c");
    code.add(function);
    code.generate(folder + "/");
    std::cout << what << " " << function.n_instructions() << "\n";
  }
};

/// Both are functions of q, v and a or tau: the values, and their derivatives along the tree.
template <class Values, class Derivatives>
void write_both(const Writer& writer, const Model& model, const std::string& what, Values&& values, Derivatives&& derivatives) {
  const Variable q("q", model.nq), v("v", model.nv), x("x", model.nv), dq("dq", model.nv);
  const std::vector<SX> in = {q.symbols, v.symbols, x.symbols};
  writer.write(what, in, {expressions(values(q.entries, v.entries, x.entries))});
  writer.write(what + "_recursive", in, derivatives(q.entries, v.entries, x.entries));

  // In the tangent space, at zero of it.
  const Vector moved = pinocchio::integrate(model, q.entries, dq.entries);
  const SX y = expressions(values(moved, v.entries, x.entries));
  std::vector<SX> slopes;
  for (const SX& by : {dq.symbols, v.symbols, x.symbols})
    slopes.push_back(SX::substitute(SX::jacobian(y, by), dq.symbols, SX::zeros(model.nv)));
  writer.write(what + "_automatic", in, slopes);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::cerr << "usage: casadi_code MODEL.txt NAME FOLDER\n";
    return 2;
  }
  pinocchio::Model numbers;
  pinocchio::serialization::loadFromText(numbers, std::string(argv[1]));
  const Model model = numbers.cast<SX>();
  Data data(model);
  const Writer writer = {argv[2], argv[3]};

  const auto rnea = [&](const Vector& q, const Vector& v, const Vector& a) -> Matrix {
    return pinocchio::rnea(model, data, q, v, a);
  };
  const auto rnea_derivatives = [&](const Vector& q, const Vector& v, const Vector& a) -> std::vector<SX> {
    pinocchio::computeRNEADerivatives(model, data, q, v, a);
    data.M.triangularView<Eigen::StrictlyLower>() = data.M.transpose().triangularView<Eigen::StrictlyLower>();
    return {expressions(data.dtau_dq), expressions(data.dtau_dv), expressions(data.M)};
  };
  const auto aba = [&](const Vector& q, const Vector& v, const Vector& tau) -> Matrix {
    return pinocchio::aba(model, data, q, v, tau);
  };
  const auto aba_derivatives = [&](const Vector& q, const Vector& v, const Vector& tau) -> std::vector<SX> {
    pinocchio::computeABADerivatives(model, data, q, v, tau);
    data.Minv.triangularView<Eigen::StrictlyLower>() = data.Minv.transpose().triangularView<Eigen::StrictlyLower>();
    return {expressions(data.ddq_dq), expressions(data.ddq_dv), expressions(data.Minv)};
  };
  write_both(writer, model, "rnea", rnea, rnea_derivatives);
  write_both(writer, model, "aba", aba, aba_derivatives);
}
