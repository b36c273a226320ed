"""`simulate`: campaigns on disk, the same for the same seed."""


def test_it_writes_a_campaign_and_says_what_is_in_it(call, tmp_path):
    done = call("simulate", tmp_path / "a", "--seed", "7", "--conditions", "2", "--repeats", "3", "--json")
    assert done.code == 0
    facts = done.json()
    assert (facts["n_conditions"], facts["n_trials"], facts["seed"]) == (2, 6, 7)
    assert (tmp_path / "a" / "truth.toml").exists()
    assert "next: ropefric extract" in done.err


def test_faults_and_parameters_can_be_chosen(call, tmp_path):
    small = ("--conditions", "1", "--repeats", "4", "--json")
    assert call("simulate", tmp_path / "a", "--no-faults", *small).json()["faults"] == {}
    assert call("simulate", tmp_path / "b", "--fault", "spike=0.5", *small).json()["faults"] == {"spike": 0.5}
    assert call("simulate", tmp_path / "c", "-p", "mu_inf=0.4", *small).json()["parameters"]["mu_inf"] == 0.4


def test_unknown_names_are_answered_with_the_nearest(call, tmp_path):
    folder = tmp_path / "a"
    assert "did you mean 'spike'?" in call("simulate", folder, "--fault", "spik=1").err
    assert "did you mean 'coupled'?" in call("simulate", folder, "--law", "coupeld").err
    assert "did you mean 'mu_inf'?" in call("simulate", folder, "-p", "mu_imf=1").err
    assert not folder.exists()
