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


def test_what_cannot_be_simulated_is_said_before_anything_is_written(call, tmp_path):
    folder, slippery = tmp_path / "a", ("--law", "constant", "-p", "mu=0.001")
    for words, said in (
        (("--fault", "spik=1"), "did you mean 'spike'?"), (("-p", "mu_imf=1"), "did you mean 'mu_inf'?"),
        (("--law", "coupeld"), "did you mean 'coupled'?"), (slippery, "parameters that give more friction"),
    ):  # fmt: skip
        assert said in call("simulate", folder, *words).err
        assert not folder.exists()
