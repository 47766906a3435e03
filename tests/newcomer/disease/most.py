import pyarrow.dataset as ds

series = ds.dataset("run/series").to_table()
print(f"at most {max(series['prevalence'].to_pylist()):.0%} ill")
