#include "graph/Program.h"

#include <isofront/core/Assert.h>

#include <algorithm>

namespace isofront::fields::graph {

namespace {

class GraphField final : public Field {
public:
    GraphField(const Node& node, const GraphSettings& settings) : _program(compiled(node, settings))
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "as many values as points");
        sampleProgram(_program, batch, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        gradientProgram(_program, batch, gradients);
    }
    void sampleWithGradient(
        const SampleBatch& batch, std::span<float> values, GradientSpans gradients) const override
    {
        sampleAndGradientProgram(_program, batch, values, gradients);
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return boundProgram(_program, box, radius);
    }
    double differenceStep(double radius) const override
    {
        // A tenth of the shortest wave; without noise, what floats can tell apart at a kilometre.
        const double finest = _program.shortest > 0 ? 0.05 * _program.shortest : 1e-3;
        double step = std::max(0.5 * radius, finest);
        for (const std::shared_ptr<const Field>& source : _program.sources)
            step = std::min(step, source->differenceStep(radius));
        return step;
    }

private:
    Program _program;
};

} // namespace

std::shared_ptr<const Field> graphField(const Node& node, const GraphSettings& settings)
{
    return std::make_shared<GraphField>(node, settings);
}

} // namespace isofront::fields::graph
