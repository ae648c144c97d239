"""What the script that compares steady responses with the literature asserts, at one number of steps."""

from experiments.curves import literature


def test_folds_and_backbone_of_the_literature_are_met() -> None:
    starts = literature.first_order_folds()
    folds, multiplier, liouville = literature.jumps(64)
    balanced = [literature.balanced_fold(5, start) for start in starts]
    assert abs(folds / balanced - 1).max() < 3e-7
    assert multiplier < 1e-9
    assert liouville < 1e-4
    assert literature.backbone(64) < 5e-6
